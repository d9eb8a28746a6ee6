// b -> a -> b
//#include "circular_a.wgsl"
