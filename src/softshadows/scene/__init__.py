"""Scenes as plain data: meshes, nodes, cameras, lights, materials, shots. Nothing here knows a GPU."""
