//#include "circular_self.wgsl"
