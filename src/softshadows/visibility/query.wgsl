// "Is light sample s visible from p?": one query, and who may answer it.
//
//     maps/shadow_map.wgsl         sample_is_visible(sample, receiver): by the sample's shadow map
//     line_maps/line_map.wgsl      map_sample_is_lit(line_map_sample(sample, receiver)): by a map rectified along the light
//     hybrid.wgsl                  classify_by_map(sample, receiver): one of the three below, by the map where it is certain
//     rays/unclassified.wgsl   stands in for it where there are no maps: UNKNOWN
//     rays/light_rays.wgsl         trace_visibility(packet): by rays, four samples of one receiver at a time
//
// All read the light whose turn it is and its samples (lights/light_samples.wgsl), and work on one chunk of them at a time. Their
// resources are bound by a Provider (provider.py).

const HIDDEN = 0u;
const LIT = 1u;
const UNKNOWN = 2u;   // until a ray finds out
