"""Is a sample of the light visible from a point? Who can answer: maps, rectified maps, rays, maps with rays."""
