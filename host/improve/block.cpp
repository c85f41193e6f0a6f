#include "host/improve/block.hpp"

#include <algorithm>
#include <limits>

#include "host/common/watch.hpp"

namespace mortise::improve {
namespace {

/// Searches per tetrahedron of the block, at most; blocks around ordinary features need two or three.
constexpr std::uint64_t kMostTries = 4;
/// Qualities computed per tetrahedron of the block, at most; ordinary blocks need less than 100, those full
/// of slivers between nearly coincident surfaces more than 800, in vain.
constexpr std::uint64_t kMostEvaluations = 100;
/// Where skins have crossed in many places there is little room, and much to look at.
constexpr std::uint64_t kMostWatchedEvaluations = 25;
/// Of the median quality, where most elements are poor: better ones are left alone.
constexpr double kBarrenPart = 0.5;
constexpr int kLookAheads = 4;
constexpr unsigned kCallsPerLook = 32;
/// The second time nodes find others out of their way: a tenth of the time, half a degree at the 1 %
/// quantile.
constexpr int kRelaxations = 2;
/// Trials of several steps in a block, at most; one per 16 tetrahedra are enough for ordinary parts.
constexpr std::uint64_t kLeastTrials = 64;
constexpr std::uint64_t kTetrahedraPerTrial = 16;

}  // namespace

void BlockCounters::add(const BlockCounters& other) {
    collapsed += other.collapsed;
    merged += other.merged;
    swapped += other.swapped;
    moved += other.moved;
    split += other.split;
    compound += other.compound;
    tried += other.tried;
    repeated += other.repeated;
    given_up += other.given_up;
}

void Block::Change::clear() {
    removed.clear();
    added.clear();
    retagged.clear();
    before = 2;
    after = 2;
    needed = 0;
    collapse = false;
    merge = false;
    gone = kNone;
    kept = kNone;
}

void Block::load(const Zone& zone, const std::vector<std::uint32_t>& tetrahedra,
                 const std::vector<std::uint32_t>& pyramids, const std::vector<std::uint8_t>& free,
                 std::vector<std::uint32_t>& place) {
    zone_node_.clear();
    points_.clear();
    size_.clear();
    unit_ = zone.unit;
    rounding_ = zone.rounding;
    free_.clear();
    shared_.clear();
    joined_.clear();
    strata_.clear();
    renewed_.clear();
    used_.clear();
    tetrahedra_.clear();
    pyramids_.clear();
    for (auto& list : star_) list.clear();
    for (auto& list : pyramid_star_) list.clear();
    const auto local = [&](ZoneNode n) {
        if (place[n] == kNone) {
            place[n] = static_cast<Local>(zone_node_.size());
            zone_node_.push_back(n);
            points_.push_back(zone.points[n]);
            size_.push_back(edge_of(zone.size_class[n]));
            free_.push_back(free[n]);
            shared_.push_back(free[n] == 0 && zone.frozen[n] == 0 ? 1 : 0);
            joined_.push_back(zone.joined[n]);
            strata_.emplace_back(zone.surfaces(n), zone.surfaces(n) + zone.stratum_size(n));
        }
        return place[n];
    };
    for (const std::uint32_t i : tetrahedra) {
        Tetrahedron t = zone.tetrahedra[i];
        for (auto& n : t.node) n = local(n);
        tetrahedra_.push_back(t);
    }
    for (const std::uint32_t i : pyramids) {
        std::array<Local, 5> p{};
        for (std::size_t k = 0; k < 5; ++k) p[k] = local(zone.pyramids[i].node[k]);
        pyramids_.push_back(p);
    }
    tip_.assign(points_.size(), 0);
    tips_.clear();
    for (const auto& tip : zone.tips) {
        if (place[tip.first] == kNone || tips_.size() == 255) continue;
        tips_.push_back(tip.second);
        tip_[place[tip.first]] = static_cast<std::uint8_t>(tips_.size());
    }
    loaded_ = static_cast<Local>(points_.size());
    alive_.assign(tetrahedra_.size(), 1);
    original_ = tetrahedra_;
    original_points_ = points_;
    clock_ = 1;
    ++version_;
    changed_.assign(points_.size(), 0);
    rested_.assign(points_.size(), 0);
    seen_at_.assign(points_.size(), 0);
    tried_.assign(tetrahedra_.size(), 0);
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) tried_[i] = tetrahedra_[i].stuck ? 1 : 0;
    looked_ = tried_;
    if (star_.size() < points_.size()) star_.resize(points_.size());
    if (pyramid_star_.size() < points_.size()) pyramid_star_.resize(points_.size());
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
        for (const Local n : tetrahedra_[i].node) star_[n].push_back(static_cast<std::uint32_t>(i));
    }
    for (std::size_t i = 0; i < pyramids_.size(); ++i) {
        for (const Local n : pyramids_[i]) pyramid_star_[n].push_back(static_cast<std::uint32_t>(i));
    }
    for (const ZoneNode n : zone_node_) place[n] = kNone;
}

Block::Result Block::result() const {
    Result result;
    result.counters = counters;
    for (const Local n : renewed_) {
        if (n < loaded_) result.strata.push_back({zone_node_[n], strata_[n]});
    }
    for (std::size_t i = 0; i < used_.size(); ++i) {
        if (used_[i] != loose_start_->used[zone_node_[i]]) result.ways.push_back({zone_node_[i], used_[i]});
    }
    for (std::size_t i = loaded_; i < points_.size(); ++i)
        result.added.push_back({points_[i], size_[i], strata_[i]});
    for (std::size_t i = 0; i < loaded_; ++i) {
        if (free_[i] != 0) result.points.push_back({zone_node_[i], points_[i]});
    }
    result.tetrahedra.reserve(count_alive());
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
        if (alive_[i] == 0) continue;
        Tetrahedron t = tetrahedra_[i];
        const bool inside = is_inside(t.node);
        t.stuck = inside && !has_changed(static_cast<std::uint32_t>(i));
        result.slivers += inside && t.quality < kMergeBelow ? 1 : 0;
        result.poor += inside && t.quality < kRelieved ? 1 : 0;
        for (auto& n : t.node) n = zone_node_[n];
        result.tetrahedra.push_back(t);
    }
    return result;
}

/// Whether a change is at nodes that are free in a later pass. Made around them it can be a dead end that
/// only repositioning would lead out of: along a crease in the plane between two blocks, in every cell alike.
bool Block::is_for_later(const Change& change) const {
    if (!options_.spares_shared) return false;
    return std::any_of(change.removed.begin(), change.removed.end(), [this](std::uint32_t i) {
        const auto& node = tetrahedra_[i].node;
        return std::any_of(node.begin(), node.end(), [this](Local n) { return shared_[n] != 0; });
    });
}

bool Block::has_changed(std::uint32_t tetrahedron) const {
    const auto& node = tetrahedra_[tetrahedron].node;
    return tried_[tetrahedron] == 0 ||
           std::any_of(node.begin(), node.end(), [&](Local n) { return changed_[n] > tried_[tetrahedron]; });
}

/// The star of a node is about to change, or has changed.
void Block::touch(Local node) {
    for (const std::uint32_t i : star_[node]) {
        for (const Local n : tetrahedra_[i].node) changed_[n] = clock_;
    }
}

void Block::apply(Change& change) {
    hand_on_shares(change);
    ++clock_;
    ++version_;
    if (running_.on) {
        for (const std::uint32_t i : change.removed) note_tetrahedron(i);
        Trial::Step step;
        step.removed = change.removed;
        step.first_added = tetrahedra_.size();
        for (const Change::Retag& r : change.retagged)
            step.tags.push_back({r.tetrahedron, r.face, tetrahedra_[r.tetrahedron].tag[r.face]});
        running_.steps.push_back(std::move(step));
    }
    for (const std::uint32_t i : change.removed) {
        alive_[i] = 0;
        for (const Local n : tetrahedra_[i].node) {
            changed_[n] = clock_;
            auto& star = star_[n];
            star.erase(std::find(star.begin(), star.end(), i));
        }
    }
    for (const Change::Retag& r : change.retagged) tetrahedra_[r.tetrahedron].tag[r.face] = r.tag;
    for (const Tetrahedron& t : change.added) {
        const auto i = static_cast<std::uint32_t>(tetrahedra_.size());
        tetrahedra_.push_back(t);
        alive_.push_back(1);
        tried_.push_back(0);
        looked_.push_back(0);
        for (const Local n : t.node) {
            star_[n].push_back(i);
            changed_[n] = clock_;
        }
        list_facets(i);
    }
    for (const Change::Retag& r : change.retagged) list_facets(r.tetrahedron);
    ++(change.collapse ? counters.collapsed : counters.swapped);
    if (!change.merge) return;
    ++counters.merged;
    if (is_loose_ && change.gone != kNone) note_way(change.gone, change.kept);
    renew_strata(change);
}

void Block::tag_added(Change& change, const std::vector<FaceEntry>& entries) const {
    if (entries.empty()) return;
    for (Tetrahedron& t : change.added) {
        for (std::size_t f = 0; f < 4; ++f) {
            const auto key =
                sorted_face({t.node[kOpposite[f][0]], t.node[kOpposite[f][1]], t.node[kOpposite[f][2]]});
            for (const FaceEntry& e : entries) {
                // Most differ in the first node, and comparing all three is a call.
                if (e.node[0] == key[0] && e.node == key && e.region == t.region) t.tag[f] = e.tag;
            }
        }
    }
}

void Block::collapse_short_edges() {
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        look_now_and_then();
        for (int e = 0; e < 6 && alive_[i] != 0; ++e) {
            const Local a = tetrahedra_[i].node[kEdgeEnds[e][0]];
            const Local b = tetrahedra_[i].node[kEdgeEnds[e][1]];
            if (!is_short_edge(a, b)) continue;
            bool found = false;
            for (int side = 0; side < 2; ++side) {
                const double better_than = found ? best_.after : 0;
                if (!examine_collapse(side == 0 ? a : b, side == 0 ? b : a, true, better_than, trial_))
                    continue;
                std::swap(trial_, best_);
                found = true;
            }
            if (found && !is_for_later(best_)) apply(best_);
        }
    }
}

/// keep_watch() for what takes microseconds: asking the time each time would cost a hundredth of all.
void Block::look_now_and_then() {
    if (++looks_ % kCallsPerLook == 0) keep_watch();
}

bool Block::improve(std::uint32_t tetrahedron) {
    look_now_and_then();
    bool found = false;
    const auto better_than = [&] { return found ? best_.after : 0; };
    const auto consider = [&](bool better) {
        if (!better || is_for_later(trial_)) return;
        std::swap(trial_, best_);
        found = true;
    };
    const std::array<Local, 4> node = tetrahedra_[tetrahedron].node;
    for (const auto& ends : kEdgeEnds) {
        const Local a = node[ends[0]];
        const Local b = node[ends[1]];
        consider(examine_edge_removal(a, b, better_than(), trial_));
        consider(examine_collapse(a, b, false, better_than(), trial_));
        consider(examine_collapse(b, a, false, better_than(), trial_));
    }
    for (std::size_t f = 0; f < 4; ++f) consider(examine_face_removal(tetrahedron, f, better_than(), trial_));
    if (found) {
        apply(best_);
        return true;
    }
    bool moved = false;
    for (const Local n : node) moved = (options_.reposition && smooth(n)) || moved;
    return moved || merge(node);
}

/// Whether most elements are worse than this: the model has no room for better ones, as in walls much thinner
/// than cells.
bool Block::is_barren(double quality) const { return 2 * count_below(quality) > count_alive(); }

/// Where all is barren searching for each element is in vain: only what is worse than the others is worked
/// on.
void Block::lower_target() {
    if (!is_barren(kGoodQuality)) return;
    std::vector<double> quality;
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
        if (alive_[i] != 0) quality.push_back(tetrahedra_[i].quality);
    }
    const auto middle = quality.begin() + static_cast<std::ptrdiff_t>(quality.size() / 2);
    std::nth_element(quality.begin(), middle, quality.end());
    options_.target = std::min(options_.target, kBarrenPart * *middle);
}

/// Sweeps over the poor elements.
void Block::sweep() {
    for (int round = 0; round < options_.rounds && counters.tried < most_tried_; ++round) {
        bool changed = false;
        for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
            if (evaluated_ > most_evaluated_) break;
            if (alive_[i] == 0 || tetrahedra_[i].quality >= options_.target || !has_changed(i)) continue;
            ++counters.tried;
            if (improve(i)) {
                changed = true;
            } else {
                tried_[i] = clock_;
            }
        }
        for (const auto& p : pyramids_) {
            if (!options_.reposition || pyramid_quality(corners(p)) >= options_.target) continue;
            for (const Local n : p) changed = smooth(n) || changed;
        }
        if (!changed) break;
        if (round == 0) lower_target();
    }
}

void Block::run(const BlockOptions& options) {
    options_ = options;
    if (options.raised_from > 0 && is_barren(options.raised_from)) return;
    if (!options.is_first) lower_target();
    last_evaluation_ = std::numeric_limits<std::uint64_t>::max();
    running_.on = false;
    if (options_.watch_facets) list_watched_facets();
    merge_close_nodes();
    // What goes now need not be watched while it moves; away from watched places all is to be as it was.
    if (options_.watch_facets && options_.watched.empty()) collapse_short_edges();
    const bool all_placed = options_.keeps_loose || project_nodes();
    collapse_short_edges();
    // What follows may mend that, but not where there is so much to do: it would be done in vain.
    if (!options_.watch_facets && has_much_poor() && has_crossed()) return;
    mend(count_alive());
    if (!all_placed && !is_hopeless()) {
        // Nodes that could not be put on their stratum may have room there now.
        project_nodes();
        mend_further();
    }
    if (!options.reposition) return;
    if (options.raised_from > 0) {
        for (int i = 0; i < kRelaxations; ++i) relax();
    } else if (options.look_ahead && count_poor() > 0 && !is_hopeless()) {
        relax();
        mend_further();
    }
}

/// Once over all nodes. Elements that are stuck below the target, each the worst for some of its nodes, get
/// nearer to it together; in the next block or step many of them are not stuck any more.
void Block::relax() {
    for (Local n = 0; n < points_.size(); ++n) {
        keep_watch();
        smooth(n, Wish::kAllBetter);
    }
}

/// Where the model itself has no room for good elements, the search must end: `tetrahedra` bounds it.
void Block::limit_search(std::uint64_t tetrahedra) {
    most_tried_ = counters.tried + kMostTries * tetrahedra;
    const bool watches_all = options_.watch_facets && options_.watched.empty();
    const std::uint64_t each = watches_all ? kMostWatchedEvaluations : kMostEvaluations;
    most_evaluated_ = std::min(evaluated_ + each * tetrahedra, last_evaluation_);
    trials_left_ = options_.look_ahead ? kLeastTrials + tetrahedra / kTetrahedraPerTrial : 0;
}

void Block::mend(std::uint64_t tetrahedra) {
    limit_search(tetrahedra);
    mend_further();
}

void Block::mend_further() {
    sweep();
    for (int again = 0; again < kLookAheads && !is_spent() && look_ahead_all(); ++again) sweep();
}

}  // namespace mortise::improve
