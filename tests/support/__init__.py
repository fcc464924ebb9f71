"""Helpers of the tests: processes, ROS domains, and an observer of what goes over the wire."""
