"""Planning: from a model, a scene and a robot to a verified joint trajectory; `sbam.planning.plan` is the way in."""
