"""People in 3D from joints or boxes that were found in the pictures of several calibrated cameras."""
