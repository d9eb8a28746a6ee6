"""The lights as the GPU knows them: one record, sets of samples, irradiance."""
