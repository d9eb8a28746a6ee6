// What shaders carry on account of drivers: stated here, and referred to by name.
//
// Rounds of loops. llvmpipe ends an invocation, without a word, after 65 535 rounds of all its loops, and watchdogs end a
// dispatch that takes seconds. Work that may take longer counts its rounds, pauses while there are enough left to come to a
// stop, and keeps what it knows in a buffer; the next dispatch goes on from there, to the same bits. A loop's body that is
// written out costs none.
//
// Loops in place of branches. llvmpipe runs the body of a branch though no invocation takes it, but not a loop's when none
// goes round. A costly body that few invocations need stands in a loop of at most one round.

override rounds_of_dispatch: u32;  // that an invocation may count; what the driver allows beside is for loops that do not

// Rounds that an invocation has left.
fn rounds_after(left: u32, spent: u32) -> u32 {
    return left - min(left, spent);
}
