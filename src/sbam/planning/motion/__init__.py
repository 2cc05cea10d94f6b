"""Dense motion: from optimised keypoints to where joints and objects are at every step of the clock."""
