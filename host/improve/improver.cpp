#include "host/improve/improver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/improve/clash.hpp"

namespace mortise::improve {
namespace {

constexpr double kBlockCells = 16;
/// Shifts of the blocks along the diagonal. Elements around a node reach two cells, half a shift: a
/// coordinate is so near a block's boundary in at most one of four passes, and every node inside a block in
/// at least one.
constexpr int kShifts = 4;
/// Bits of a block's place along an axis in its key.
constexpr int kPlaceBits = 20;
/// As kTetrahedraPerPoor, for a larger angle, which most elements at surfaces have to work for.
constexpr std::size_t kTetrahedraPerRaised = 4;
/// More poor elements than this after plain changes are films, or surfaces without room: changes of several
/// steps mend one in twenty of them, in two thirds of the time.
constexpr double kLostShare = 0.9;
/// Fewer may be a corner of what the block of another pass has all of.
constexpr std::size_t kLeastLost = 500;
constexpr std::uint32_t kMixed = 0xfffffffeu;
constexpr std::size_t kRunChunk = 4096;
/// Cells with more tetrahedra hold far more surfaces than they can show; those of a gyroid or a bracket have
/// 80 at most.
constexpr std::size_t kCrowdedCell = 400;
/// At a block: plain, facets watched where they have crossed, watched everywhere, with single changes only,
/// without changes of facets.
constexpr int kMostAttempts = 5;
/// Loose nodes go to kMostLoose in so many steps: not farther than needed.
constexpr int kLooseParts = 3;

/// Consecutive elements of one block, in the list of the zone's tetrahedra and then its pyramids.
struct Run {
    std::uint64_t block;
    std::uint32_t begin, end;
    bool operator<(const Run& other) const {
        return block != other.block ? block < other.block : begin < other.begin;
    }
};

/// Facets have crossed: watches them there, the next time everywhere. False if that has been done.
bool watch_more(const Block& block, BlockOptions& options) {
    if (options.watch_facets && options.watched.empty()) return false;
    options.watched = options.watch_facets ? std::vector<Bounds>{} : block.crossed_places();
    options.watch_facets = true;
    return true;
}

/// Whatever goes wrong in a block, the mesh stays valid: the block is done again more carefully, or false
/// is returned. The block has been loaded.
template <class Load>
bool run_carefully(Block& block, const Load& load, BlockOptions options) {
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
        if (attempt > 0) load();
        block.counters = {};
        block.counters.repeated = attempt > 0 ? 1 : 0;
        block.run(options);
        const bool sound = block.verify();
        if (sound && !block.has_crossed()) return true;
        if (!options.change_boundary) break;
        if (sound && watch_more(block, options)) continue;
        if (sound && options.merge_distance > 0) break;  // nodes that become one take their facets along
        options.change_boundary = options.look_ahead;
        options.move_boundary = options.look_ahead;
        options.look_ahead = false;
    }
    return false;
}

/// What the block has become, with smaller elements where these help.
Block::Result refined(Block& block) {
    if (!block.may_refine()) return block.result();
    const Block before = block;
    if (block.refine() && (!block.verify() || block.has_crossed())) return before.result();
    return block.result();
}

template <class Load>
std::optional<Block::Result> run_and_refine(Block& block, const Load& load, const BlockOptions& options) {
    if (!run_carefully(block, load, options)) return std::nullopt;
    return refined(block);
}

}  // namespace

/// Blocks of two sizes share their passes in a graded tree. Around a node of a balanced tree are leaves of at
/// most two sizes, so one of the two pairings has all its elements.
int Improver::pass_count() const {
    const bool is_graded = std::any_of(zone_.size_class.begin(), zone_.size_class.end(),
                                       [this](std::uint8_t c) { return c != zone_.size_class.front(); });
    return is_graded ? 2 * kShifts : kShifts;
}

BlockOptions Improver::block_options(int number, Effort effort) const {
    BlockOptions options;
    options.look_ahead = effort != Effort::kPlain;
    options.reposition = options_.smooth > 0;
    options.keeps_loose = options_.keeps_loose;
    // Where nodes are repositioned they get out of the way; after the last pass there is no later one.
    options.spares_shared = options_.smooth == 0 && effort == Effort::kPlain && number + 1 < pass_count();
    options.is_first = aim_.is_first;
    options.raised_from = aim_.raised_from;
    options.target = aim_.target;
    options.rounds = std::max(2, 2 * options_.smooth);
    return options;
}

/// The groups, those first that take longest, so that no thread is left with one of them at the end.
std::vector<std::uint32_t> Improver::longest_first() const {
    std::vector<std::uint32_t> order(groups_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
        return groups_[a].poor_count > groups_[b].poor_count;
    });
    return order;
}

/// What a pass makes of each block; nodes that stay in the zone are moved there. Blocks that nothing is to be
/// done about, or that failed, have no result, and count as given up but where nothing was poor.
std::vector<Block::Result> Improver::run_blocks(int number, Effort effort) {
    const BlockOptions options = block_options(number, effort);
    const auto threads = static_cast<std::size_t>(thread_count(options_.threads));
    std::vector<Block> blocks(threads, Block(surfaces_));
    std::vector<std::vector<std::uint32_t>> place(threads);
    std::vector<Block::Result> results(groups_.size());
    const std::vector<std::uint32_t> order = longest_first();
    parallel_chunks(order.size(), 1, options_.threads, [&](std::size_t i, std::size_t, int thread) {
        const std::uint32_t g = order[i];
        const Group& group = groups_[g];
        if (!group.poor) return;
        results[g].counters.given_up = 1;
        if (group.crowded || (effort != Effort::kPlain && group.lost)) return;
        auto& scratch = place[static_cast<std::size_t>(thread)];
        if (scratch.empty()) scratch.assign(zone_.points.size(), kNone);
        Block& block = blocks[static_cast<std::size_t>(thread)];
        const auto load = [&] { block.load(zone_, group.tetrahedra, group.pyramids, free_, scratch); };
        std::optional<Block::Result> result =
            effort == Effort::kLoosen ? loosen_block(block, load, options) : run_block(block, load, options);
        if (!result) return;
        for (const auto& [node, point] : result->points) zone_.points[node] = point;
        result->points = {};
        results[g] = std::move(*result);
    });
    return results;
}

/// Cells of two sizes share their blocks, which have kBlockCells of the larger along an edge: those of
/// classes -1 and 0, 1 and 2, 3 and 4, … above the finest for the first passes, of 0 and 1, 2 and 3, … for
/// the others.
void Improver::pass(int number, Effort effort, Counters& counters) {
    const int pairing = number / kShifts, shift = number % kShifts;
    group(pairing, kBlockCells / kShifts * shift, effort == Effort::kLoosen ? kLoosenBelow : aim_.target);
    find_free_nodes();
    std::vector<Point> before = zone_.points;
    std::vector<Block::Result> results = run_blocks(number, effort);
    aim_.is_first = false;
    std::vector<BlockCounters> counted;
    std::vector<Piece> pieces(groups_.size());
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
        Block::Result& result = results[g];
        number_added(g, result.added, result.tetrahedra);
        counted.push_back(result.counters);
        if (groups_[g].poor && result.counters.given_up == 0)
            pieces[g] = {true, result.tetrahedra.data(), result.tetrahedra.size()};
    }
    before.resize(zone_.points.size(), {HUGE_VAL, HUGE_VAL, HUGE_VAL});
    std::vector<Tetrahedron> all = join(pieces);
    for (Block::Result& result : results) result.tetrahedra = {};
    while (revert_clashes(before, all, counted)) {
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (counted[g].given_up == 0) {
            zone_.set_strata(results[g].strata);
            loose_start_.add(results[g].ways);
        }
        counters.block.add(counted[g]);
    }
    zone_.tetrahedra = std::move(all);
}

/// Gives the nodes that a block has added their numbers in the zone.
void Improver::number_added(std::uint32_t group, const std::vector<Block::NewNode>& added,
                            std::vector<Tetrahedron>& tetrahedra) {
    if (added.empty()) return;
    const auto first = static_cast<ZoneNode>(zone_.points.size());
    for (const Block::NewNode& node : added) zone_.add_node(node.at, std::ilogb(node.size), node.stratum);
    owner_.resize(zone_.points.size(), group);
    for (Tetrahedron& t : tetrahedra) {
        for (ZoneNode& n : t.node) {
            if (n >= kNewNode) n = first + (n - kNewNode);
        }
    }
}

bool Improver::is_hopeless() const {
    const auto poor = std::count_if(zone_.tetrahedra.begin(), zone_.tetrahedra.end(),
                                    [this](const Tetrahedron& t) { return t.quality < aim_.target; });
    const std::size_t each = aim_.raised_from > 0 ? kTetrahedraPerRaised : kTetrahedraPerPoor;
    return static_cast<std::size_t>(poor) > zone_.tetrahedra.size() / each;
}

void Improver::loosen(Counters& counters) {
    const auto has_poor = [this] {
        return std::any_of(zone_.tetrahedra.begin(), zone_.tetrahedra.end(),
                           [](const Tetrahedron& t) { return t.quality < kLoosenBelow; });
    };
    if (!has_poor()) return;
    loose_start_ = find_loose_start(zone_, options_.merge_distance);
    const int passes = pass_count();
    for (int i = 0; i < kLooseParts * passes && has_poor(); ++i) {
        loose_start_.reach = kMostLoose * options_.merge_distance * (i / passes + 1) / kLooseParts;
        pass(i % passes, Effort::kLoosen, counters);
    }
    counters.loosened = count_loose(zone_, loose_start_, surfaces_);
}

bool Improver::is_done() const {
    return std::none_of(zone_.tips.begin(), zone_.tips.end(),
                        [this](const auto& tip) { return is_unplaced(tip); }) &&
           std::none_of(zone_.tetrahedra.begin(), zone_.tetrahedra.end(),
                        [this](const Tetrahedron& t) { return t.quality < aim_.target; }) &&
           std::none_of(zone_.pyramids.begin(), zone_.pyramids.end(),
                        [this](const Pyramid& p) { return quality_of(p) < aim_.target; });
}

/// Merging is for what nothing else helps, changes of several steps and smaller elements neither; but
/// where creases run side by side there is no doubt.
template <class Load>
std::optional<Block::Result> Improver::run_block(Block& block, const Load& load,
                                                 const BlockOptions& plain) const {
    load();
    if (aim_.raised_from > 0) {
        if (!run_carefully(block, load, plain)) return std::nullopt;
        return block.result();
    }
    if (!(options_.merge_distance > 0)) return run_and_refine(block, load, plain);
    BlockOptions merging = plain;
    merging.merge_distance = options_.merge_distance;
    const bool merges_first = block.has_creases_side_by_side(options_.merge_distance);
    if (!run_carefully(block, load, merges_first ? merging : plain)) {
        load();
        return run_and_refine(block, load, merges_first ? plain : merging);
    }
    if (merges_first || !plain.look_ahead || !block.has_slivers()) return refined(block);
    Block merged = block;
    Block::Result result = refined(block);
    if (result.poor == 0 || !merged.merge_slivers(options_.merge_distance) || !merged.verify() ||
        merged.has_crossed())
        return result;
    Block::Result other = refined(merged);
    const auto is_better = [](const Block::Result& a, const Block::Result& b) {
        return a.slivers != b.slivers ? a.slivers < b.slivers : a.poor < b.poor;
    };
    return is_better(other, result) ? other : result;
}

template <class Load>
std::optional<Block::Result> Improver::loosen_block(Block& block, const Load& load, BlockOptions options) {
    options.merge_distance = options_.merge_distance;
    load();
    block.counters = {};
    if (!block.loosen(options, loose_start_) || !block.verify() || block.has_crossed()) return std::nullopt;
    return block.result();
}

double Improver::quality_of(const Pyramid& p) const {
    std::array<Point, 5> corners;
    for (std::size_t k = 0; k < 5; ++k) corners[k] = zone_.points[p.node[k]];
    return pyramid_quality(corners);
}

template <class Nodes>
Improver::Place Improver::place_of(const Nodes& nodes) const {
    Place place;
    for (const ZoneNode n : nodes) {
        place.sum = place.sum + zone_.points[n];
        place.size_class = std::max<int>(place.size_class, zone_.size_class[n]);
    }
    return place;
}

template <class Nodes>
std::uint64_t Improver::block_of(const Nodes& nodes, int pairing, double shift) const {
    const Place place = place_of(nodes);
    const int pair = (place.size_class - zone_.finest_class + 1 - pairing) / 2;
    const double per_cell = 1 / edge_of(zone_.finest_class + 2 * pair + pairing);
    auto key = static_cast<std::uint64_t>(pair);
    for (const double x : place.sum) {
        const double at = x * per_cell / static_cast<double>(nodes.size()) + shift + kBlockCells;
        // Cut off, which is the same as rounded down: a call, three times for each element.
        const auto place_on_axis = static_cast<std::int64_t>(std::max(0.0, at / kBlockCells));
        key = (key << kPlaceBits) | static_cast<std::uint64_t>(place_on_axis);
    }
    return key;
}

/// Whether most of these are in cells with more than kCrowdedCell of them.
bool Improver::is_crowded(const std::vector<std::uint32_t>& tetrahedra) const {
    if (tetrahedra.size() <= kCrowdedCell) return false;
    using Cell = std::array<std::int32_t, 3>;
    std::vector<std::pair<Cell, std::size_t>> counts;  // those of a cell are mostly one behind the other
    for (const std::uint32_t t : tetrahedra) {
        const Place place = place_of(zone_.tetrahedra[t].node);
        const double per_cell = 0.25 / edge_of(place.size_class);
        Cell cell{};
        for (std::size_t k = 0; k < 3; ++k)
            cell[k] = static_cast<std::int32_t>(std::floor(place.sum[k] * per_cell));
        if (counts.empty() || counts.back().first != cell) counts.push_back({cell, 0});
        ++counts.back().second;
    }
    std::sort(counts.begin(), counts.end());
    std::size_t crowded = 0;
    for (std::size_t i = 0; i < counts.size();) {
        const Cell& cell = counts[i].first;
        std::size_t count = 0;
        for (; i < counts.size() && counts[i].first == cell; ++i) count += counts[i].second;
        if (count > kCrowdedCell) crowded += count;
    }
    return 2 * crowded > tetrahedra.size();
}

/// The tetrahedra of all blocks; sets first_.
std::vector<Tetrahedron> Improver::join(const std::vector<Piece>& pieces) {
    first_.assign(1, 0);
    for (std::size_t g = 0; g < groups_.size(); ++g)
        first_.push_back(first_.back() + (pieces[g].is_new ? pieces[g].count : groups_[g].tetrahedra.size()));
    std::vector<Tetrahedron> all;
    resize_large(all, first_.back(), options_.threads);
    parallel_chunks(groups_.size(), 1, options_.threads, [&](std::size_t g, std::size_t, int) {
        Tetrahedron* to = all.data() + first_[g];
        if (pieces[g].is_new) {
            std::copy_n(pieces[g].begin, pieces[g].count, to);
            return;
        }
        for (const std::uint32_t i : groups_[g].tetrahedra) *to++ = zone_.tetrahedra[i];
    });
    return all;
}

/// Takes back, in `all`, what blocks have done that do not go together; false if there are none.
bool Improver::revert_clashes(const std::vector<Point>& before, std::vector<Tetrahedron>& all,
                              std::vector<BlockCounters>& counted) {
    std::vector<std::uint8_t> changed(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        changed[g] = groups_[g].poor && counted[g].given_up == 0 ? 1 : 0;
    }
    const std::vector<std::uint32_t> clashing = find_clashes(
        {before, zone_.points, owner_, kMixed, all, first_, changed, zone_.unit}, options_.threads);
    if (clashing.empty()) return false;
    std::vector<Piece> pieces(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g)
        pieces[g] = {true, all.data() + first_[g], first_[g + 1] - first_[g]};
    for (const std::uint32_t g : clashing) {
        pieces[g] = {};
        counted[g] = {};
        counted[g].given_up = 1;
    }
    for (std::size_t n = 0; n < before.size(); ++n) {
        if (std::binary_search(clashing.begin(), clashing.end(), owner_[n])) zone_.points[n] = before[n];
    }
    all = join(pieces);
    return true;
}

/// `least`: blocks with an element of less quality are poor.
void Improver::group(int pairing, double shift, double least) {
    const std::size_t tetrahedra = zone_.tetrahedra.size();
    const std::size_t count = tetrahedra + zone_.pyramids.size();
    // Neighbours in the list are in the same block, mostly.
    std::vector<std::vector<Run>> found(chunk_count(count, kRunChunk));
    parallel_chunks(count, kRunChunk, options_.threads, [&](std::size_t begin, std::size_t end, int) {
        std::vector<Run>& list = found[begin / kRunChunk];
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint64_t block = i < tetrahedra
                                            ? block_of(zone_.tetrahedra[i].node, pairing, shift)
                                            : block_of(zone_.pyramids[i - tetrahedra].node, pairing, shift);
            if (list.empty() || list.back().block != block)
                list.push_back({block, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i)});
            ++list.back().end;
        }
    });
    std::vector<Run> runs;
    append_lists(found, options_.threads, runs);
    parallel_sort(runs, options_.threads);
    std::vector<ZoneNode> waiting;
    for (const auto& tip : zone_.tips) {
        if (is_unplaced(tip)) waiting.push_back(tip.first);
    }
    std::sort(waiting.begin(), waiting.end());
    const auto waits = [&](ZoneNode n) { return std::binary_search(waiting.begin(), waiting.end(), n); };
    const auto is_poor = [&](const Tetrahedron& t) {
        return t.quality < least || (!waiting.empty() && std::any_of(t.node.begin(), t.node.end(), waits));
    };
    groups_.clear();
    std::vector<std::size_t> begins;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        if (r > 0 && runs[r].block == runs[r - 1].block) continue;
        begins.push_back(r);
        groups_.emplace_back();
    }
    begins.push_back(runs.size());
    parallel_chunks(groups_.size(), 1, options_.threads, [&](std::size_t g, std::size_t, int) {
        Group& group = groups_[g];
        const auto add = [&](std::uint32_t at) {
            if (at < tetrahedra) {
                group.tetrahedra.push_back(at);
                group.poor = group.poor || is_poor(zone_.tetrahedra[at]);
                if (zone_.tetrahedra[at].quality < least) ++group.poor_count;
            } else {
                group.pyramids.push_back(static_cast<std::uint32_t>(at - tetrahedra));
                group.poor = group.poor || quality_of(zone_.pyramids[at - tetrahedra]) < least;
            }
        };
        for (std::size_t r = begins[g]; r < begins[g + 1]; ++r) {
            for (std::uint32_t i = runs[r].begin; i < runs[r].end; ++i) add(i);
        }
        group.lost =
            !(aim_.raised_from > 0) && group.poor_count >= kLeastLost &&
            static_cast<double>(group.poor_count) > kLostShare * static_cast<double>(group.tetrahedra.size());
        group.crowded = group.poor && is_crowded(group.tetrahedra);
    });
}

void Improver::find_free_nodes() {
    owner_.assign(zone_.points.size(), kNone);
    const auto use = [&](ZoneNode n, std::uint32_t group) {
        owner_[n] = owner_[n] == kNone || owner_[n] == group ? group : kMixed;
    };
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
        for (const std::uint32_t i : groups_[g].tetrahedra) {
            for (const ZoneNode n : zone_.tetrahedra[i].node) use(n, g);
        }
        for (const std::uint32_t i : groups_[g].pyramids) {
            for (const ZoneNode n : zone_.pyramids[i].node) use(n, g);
        }
    }
    free_.assign(zone_.points.size(), 0);
    for (std::size_t i = 0; i < owner_.size(); ++i) free_[i] = owner_[i] < kMixed && zone_.frozen[i] == 0;
}

}  // namespace mortise::improve
