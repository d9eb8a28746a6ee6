"""What every frame has, whatever its technique: the G-buffer and the shading."""
