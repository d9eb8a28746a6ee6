// What is known of a light sample.

const HIDDEN = 0u;
const LIT = 1u;
const UNKNOWN = 2u;   // until a ray finds out
