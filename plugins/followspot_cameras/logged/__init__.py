"""Pictures in the log files of other programs: MCAP files and ROS bags."""
