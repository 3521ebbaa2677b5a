"""What a robot is holding, from the torques of its own joints."""
