// An extension enabled in a file that is included after declarations.
const FIRST = 1u;
//#include "enable_part.wgsl"
