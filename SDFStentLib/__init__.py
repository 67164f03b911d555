"""Virtual stenting of vessel surfaces: NumPy in, NumPy out, millimetres everywhere."""
