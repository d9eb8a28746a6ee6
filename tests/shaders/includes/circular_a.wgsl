// a -> b -> a
//#include "circular_b.wgsl"
