"""`calibrate wand`: cameras from a bright point waved through the room (Svoboda, Martinec & Pajdla 2005)."""
