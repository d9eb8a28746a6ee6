enable clip_distances;
const SECOND = 2u;
