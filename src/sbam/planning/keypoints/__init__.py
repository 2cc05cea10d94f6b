"""The optimisation at the keypoints (paper, section III-D): from learned changes to one configuration per keypoint."""
