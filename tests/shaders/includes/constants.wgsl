// Included twice, and here once.
const ANSWER = 42u;
