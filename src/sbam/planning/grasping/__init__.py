"""Grasps: from an object's grasp regions and its way through the action to combinations that all hands can hold."""
