// The light's trees on the GPU: what the kernels of this folder share (bind group 3; each declares what it uses).
//
// A *tree* is the set of cells that some part of the picture has refined: one for every tile of 8×8 pixels, or a single
// one for the whole picture (the paper's). A cell is *present* in a tree if its parent is refined, a *leaf* if it is present
// and not refined itself. A tree *requests* the samples at the corners of its cells.
//
// All of it is rows of bits, so that a row of cells is worked on at once. Sample (x, y) of the lattice is bit x of row y. A
// cell is the bit of its lower left corner: at level d, whose cells are `spacing` samples wide, cell (i, j) is bit
// i × spacing of the level's row j, and its corners are the bits there and `spacing` farther in the sample rows
// j × spacing and (j + 1) × spacing. On a line there is one row of either, and corners coincide in pairs.

//#struct TreeShape

const TILE = 8u;
const PIXELS = 64u;        // of a tile
const QUADRANT = 4u;       // pixels along the side of a tile's quadrant
const QUADRANTS = 4u;
const MOST_LEVELS = 5u;
const MOST_ROWS = 17u;
const MOST_SAMPLES = 289u;
const CELLS_PER_ROW = 16u; // at most
const GROUPS_PER_ROW = 256u;  // of an indirect dispatch over a list, which may be longer than one dimension allows

const SHADOW_MAPS = 0u;   // what a frame reports over all its lights, by word
const CAPPED_TILES = 1u;  // where the deepest level fails too
const LOOKUPS_LOW = 2u;   // of all pixels, 64 bits
const LOOKUPS_HIGH = 3u;
const CUT_SHORT = 4u;       // a ray ended before its end

@group(3) @binding(0) var<uniform> shape: TreeShape;

// What the levels hand on to each other.
struct LevelState {
    sample_count: u32,      // requested by some tree: the level's maps
    tile_size: u32,         // of its maps, texels
    tiles_per_row: u32,
    active_tiles: atomic<u32>,
};
struct Control {
    levels: array<LevelState, MOST_LEVELS>,
    needed: array<atomic<u32>, MOST_ROWS>,     // samples that some tree requests
    ranked: array<u32, MOST_SAMPLES>,          // the level's requested samples, in order
    cut_short: atomic<u32>,                    // not 0: a ray ended before its end
    bracket_rays: atomic<u32>,
    tile_lists: array<u32>,                    // the active tiles of every level, one list after the other
};

fn spacing(level: u32) -> u32 {
    return 1u << (shape.deepest - level);
}

// The children of a row of cells, in either of the rows of `level` that they fill.
fn children_of(parents: u32, level: u32) -> u32 {
    return parents | (parents << spacing(level));
}

// The row of cells above `level` that the parents of its row `row` are in.
fn parent_row(row: u32) -> u32 {
    return select(0u, row / 2u, shape.has_rows == 1u);
}

fn cell_rows(level: u32) -> u32 {
    return select(1u, 1u << level, shape.has_rows == 1u);
}

// Rows of cells above the level, which is where its own begin.
fn first_cell_row(level: u32) -> u32 {
    return select(level, (1u << level) - 1u, shape.has_rows == 1u);
}

// The two rows of samples at the corners of a level's row of cells.
fn sample_rows(level: u32, row: u32) -> vec2u {
    return select(vec2u(0u), vec2u(row, row + 1u) * spacing(level), shape.has_rows == 1u);
}

// From a cell's bit to that of its right corners.
fn right_shift(level: u32) -> u32 {
    return select(0u, spacing(level), shape.has_columns == 1u);
}

fn tiles_across() -> u32 {
    return (shape.image_size.x + TILE - 1u) / TILE;
}

fn tile_count() -> u32 {
    return tiles_across() * ((shape.image_size.y + TILE - 1u) / TILE);
}

fn tree_of(tile: u32) -> u32 {
    return select(tile, 0u, shape.is_global == 1u);
}

fn tile_origin(tile: u32) -> vec2u {
    return TILE * vec2u(tile % tiles_across(), tile / tiles_across());
}

// The eight tiles or texels around one, row by row; opposite ones add up to 7.
fn neighbour(i: u32) -> vec2i {
    let at = i32(select(i + 1u, i, i < 4u));
    return vec2i(at % 3, at / 3) - 1;
}

// A tile's place in a list that an indirect dispatch runs over.
fn list_index(group: vec3u) -> u32 {
    return group.y * GROUPS_PER_ROW + group.x;
}

// Where a pixel's look-ups are stored: two rows of 16 samples to a word, then a word with every row's 17th.
fn mask_index(tile: u32, word: u32, lane: u32) -> u32 {
    return (tile * mask_words() + word) * PIXELS + lane;
}

// Where, in place of a tile, bits say which samples the maps were not certain about.
fn unknown_by(tile: u32) -> u32 {
    return tile_count() + tile;
}

fn mask_words() -> u32 {
    return (shape.sample_rows + 1u) / 2u + 1u;
}

// A tree's words in `trees`: the samples that it requests, row by row, and then its refined cells, by level and row of cells.
fn request_index(tree: u32, row: u32) -> u32 {
    return tree * (shape.sample_rows + shape.refined_rows) + row;
}

fn refined_index(tree: u32, level: u32, row: u32) -> u32 {
    return request_index(tree, shape.sample_rows + first_cell_row(level) + row);
}

// Where a tree's row of cells stands among those of all trees.
fn cell_row_index(tree: u32, level: u32, row: u32) -> u32 {
    return tree * shape.refined_rows + first_cell_row(level) + row;
}

// Where the number of a cell's failing texels is kept, if there is a threshold.
fn count_index(tree: u32, level: u32, row: u32, cell: u32) -> u32 {
    return cell_row_index(tree, level, row) * CELLS_PER_ROW + cell / spacing(level);
}

// Where a tree's failures are kept, by row of cells and quadrant of the tile.
fn failure_index(tree: u32, level: u32, row: u32, quadrant: u32) -> u32 {
    return cell_row_index(tree, level, row) * QUADRANTS + quadrant;
}

// Where it is kept that a tile fails at the deepest level.
fn capped_index(tile: u32) -> u32 {
    return select(tile_count(), 1u, shape.is_global == 1u) * shape.refined_rows * QUADRANTS + tile;
}
