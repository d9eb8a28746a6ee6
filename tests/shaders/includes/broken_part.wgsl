//#struct Pair

fn wrong(pair: Pair) -> f32 {
    return pair.third;
}
