// The level that a dispatch works on, and the samples that appear first there.

//#needs spacing
//#struct Step

@group(3) @binding(10) var<uniform> step: Step;

fn new_samples(row: u32) -> u32 {
    if row % spacing(step.level) != 0u {
        return 0u;
    }
    let is_old_row = row % (2u * spacing(step.level)) == 0u;
    return select(step.samples, step.samples & ~step.older_samples, is_old_row);
}
