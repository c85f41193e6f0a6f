// Changes of several steps, for elements that no single change improves.
//
// The first step may make things worse; then the worst element that has been touched must get better step by
// step, until it is better than the worst of them all was before. Otherwise all steps are undone.
#include <algorithm>

#include "host/common/watch.hpp"
#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kMostTrials = 8;  ///< first steps that are tried for an element, the best ones
constexpr std::size_t kFewPoor = 32;
constexpr std::size_t kManyPoor = 1000;
constexpr double kMostTrialSag = 0.1;      ///< of a facet, in cells, unless it was larger
constexpr std::size_t kMostTouched = 512;  ///< elements; more are around needles of the model
constexpr int kMostSteps = 8;              ///< in a trial

}  // namespace

struct Block::Candidate {
    enum Kind : std::uint8_t { kCollapse, kEdge, kFace };
    Kind kind;
    Local a;  ///< of a face: the number in the element
    Local b;
    double after;
};

void Block::note_tetrahedron(std::uint32_t tetrahedron) {
    if (tetrahedron >= running_.tetrahedra) return;
    if (std::find(running_.touched.begin(), running_.touched.end(), tetrahedron) != running_.touched.end())
        return;
    running_.touched.push_back(tetrahedron);
    running_.sag = std::max(running_.sag, worst_sag(tetrahedron));
    running_.before = std::min(running_.before, tetrahedra_[tetrahedron].quality);
}

/// Whether the facets that have been touched are as close to their surfaces as they were, or close enough.
bool Block::trial_stays_close() const {
    const double limit = std::max(running_.sag, kMostTrialSag);
    const auto close = [&](std::uint32_t i) { return alive_[i] == 0 || worst_sag(i) <= limit; };
    for (auto i = static_cast<std::uint32_t>(running_.tetrahedra); i < tetrahedra_.size(); ++i) {
        if (!close(i)) return false;
    }
    return std::all_of(running_.touched.begin(), running_.touched.end(), close);
}

/// The node is about to move.
void Block::note_move(Local node) {
    for (const std::uint32_t i : star_[node]) note_tetrahedron(i);
    for (const std::uint32_t i : pyramid_star_[node]) {
        if (std::find(running_.pyramids.begin(), running_.pyramids.end(), i) != running_.pyramids.end())
            continue;
        running_.pyramids.push_back(i);
        running_.before = std::min(running_.before, pyramid_quality(corners(pyramids_[i])));
    }
    Trial::Step step;
    step.first_added = tetrahedra_.size();
    step.moved = node;
    step.from = points_[node];
    running_.steps.push_back(std::move(step));
}

void Block::begin_trial() {
    running_.on = true;
    running_.before = 2;
    running_.sag = 0;
    running_.touched.clear();
    running_.pyramids.clear();
    running_.steps.clear();
    running_.tetrahedra = tetrahedra_.size();
    running_.clock = clock_;
    running_.changed = changed_;
    running_.rested = rested_;
    running_.tried = tried_;
    running_.counters = counters;
}

void Block::undo_trial() {
    running_.on = false;
    ++version_;
    for (auto step = running_.steps.rbegin(); step != running_.steps.rend(); ++step) {
        if (step->moved != kNone) {
            points_[step->moved] = step->from;
            divide_shares(step->moved);
            for (const std::uint32_t i : star_[step->moved])
                tetrahedra_[i].quality = quality(tetrahedra_[i].node);
            continue;
        }
        for (std::size_t i = tetrahedra_.size(); i-- > step->first_added;) {
            for (const Local n : tetrahedra_[i].node) {
                auto& star = star_[n];
                star.erase(std::find(star.begin(), star.end(), static_cast<std::uint32_t>(i)));
            }
        }
        tetrahedra_.resize(step->first_added);
        alive_.resize(step->first_added);
        looked_.resize(step->first_added);
        for (const auto& r : step->tags) tetrahedra_[r.tetrahedron].tag[r.face] = r.tag;
        for (const std::uint32_t i : step->removed) {
            alive_[i] = 1;
            for (const Local n : tetrahedra_[i].node) star_[n].push_back(i);
        }
    }
    clock_ = running_.clock;
    changed_ = running_.changed;
    rested_ = running_.rested;
    tried_ = running_.tried;
    counters = running_.counters;
}

bool Block::examine(const Candidate& c, std::uint32_t tetrahedron, Change& change) {
    switch (c.kind) {
        case Candidate::kCollapse: return examine_collapse(c.a, c.b, false, 0, change);
        case Candidate::kEdge: return examine_edge_removal(c.a, c.b, 0, change);
        case Candidate::kFace: return examine_face_removal(tetrahedron, c.a, 0, change);
    }
    return false;
}

void Block::gather_candidates(std::uint32_t tetrahedron, std::vector<Candidate>& candidates) {
    candidates.clear();
    const std::array<Local, 4> node = tetrahedra_[tetrahedron].node;
    const auto consider = [&](Candidate c) {
        if (!examine(c, tetrahedron, trial_)) return;
        c.after = trial_.after;
        candidates.push_back(c);
    };
    for (const auto& ends : kEdgeEnds) {
        const Local a = node[ends[0]];
        const Local b = node[ends[1]];
        consider({Candidate::kEdge, a, b, 0});
        consider({Candidate::kCollapse, a, b, 0});
        consider({Candidate::kCollapse, b, a, 0});
    }
    for (Local f = 0; f < 4; ++f) consider({Candidate::kFace, f, 0, 0});
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.after > y.after; });
    if (candidates.size() > kMostTrials) candidates.resize(kMostTrials);
}

/// Improves what the first step has touched, the worst first; whether that ends better than it was.
bool Block::finish_trial() {
    for (int step = 0; step < kMostSteps && running_.touched.size() <= kMostTouched; ++step) {
        double worst = 2;
        std::uint32_t at = kNone;
        const auto ask = [&](std::uint32_t i) {
            if (alive_[i] == 0 || tetrahedra_[i].quality >= worst) return;
            worst = tetrahedra_[i].quality;
            at = i;
        };
        for (const std::uint32_t i : running_.touched) ask(i);
        for (auto i = static_cast<std::uint32_t>(running_.tetrahedra); i < tetrahedra_.size(); ++i) ask(i);
        for (const std::uint32_t i : running_.pyramids)
            worst = std::min(worst, pyramid_quality(corners(pyramids_[i])));
        if (worst > running_.before * kLeastGain) return trial_stays_close();
        if (at == kNone || !improve(at)) return false;
    }
    return false;
}

bool Block::look_ahead(std::uint32_t tetrahedron) {
    keep_watch();
    std::vector<Candidate> candidates;
    least_gain_ = 0;
    gather_candidates(tetrahedron, candidates);
    for (const Candidate& c : candidates) {
        least_gain_ = 0;
        const bool possible = examine(c, tetrahedron, trial_);
        least_gain_ = kLeastGain;
        if (!possible) continue;
        if (trials_left_ == 0) break;
        --trials_left_;
        begin_trial();
        apply(trial_);
        if (finish_trial()) {
            running_.on = false;
            ++counters.compound;
            return true;
        }
        undo_trial();
    }
    least_gain_ = kLeastGain;
    return false;
}

bool Block::is_hopeless() const { return count_poor() > kFewPoor + original_.size() / kTetrahedraPerPoor; }

/// Whether a long search is mostly in vain where facets have crossed.
bool Block::has_much_poor() const { return count_poor() > kManyPoor + original_.size() / 4; }

/// Looks ahead from every element that is still poor and whose nodes are all free, the worst first.
bool Block::look_ahead_all() {
    if (is_hopeless()) return false;
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        const Tetrahedron& t = tetrahedra_[i];
        if (alive_[i] == 0 || t.quality >= options_.target) continue;
        if (std::any_of(t.node.begin(), t.node.end(), [&](Local n) { return free_[n] == 0; })) continue;
        order.push_back({t.quality, i});
    }
    std::sort(order.begin(), order.end());
    bool found = false;
    for (const auto& entry : order) {
        if (trials_left_ == 0) break;
        const std::uint32_t i = entry.second;
        if (alive_[i] == 0 || tetrahedra_[i].quality >= options_.target) continue;
        const auto& node = tetrahedra_[i].node;
        const std::uint32_t since = std::max(looked_[i], looks_since_);
        if (since != 0 &&
            std::none_of(node.begin(), node.end(), [&](Local n) { return changed_[n] > since; }))
            continue;
        if (look_ahead(i)) {
            found = true;
        } else {
            looked_[i] = clock_;
        }
    }
    return found;
}

}  // namespace mortise::improve
