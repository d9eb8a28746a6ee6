// Numbers that several shaders use.

const PI = 3.14159265;
const TINY = 1e-30;  // keeps 0 / 0 at 0
