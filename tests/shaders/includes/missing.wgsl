// The next line names a file that is not there.
//#include "nowhere.wgsl"
