#include "host/improve/improve.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "host/common/constants.hpp"
#include "host/improve/improver.hpp"
#include "host/improve/poor_cells.hpp"
#include "kernels/shared/elementary.h"

namespace mortise::improve {
namespace {

/// What stays poor is often held by the border of the zone: the next zone, around it, has its border
/// elsewhere. The small ones also try changes of several steps; most of what is stuck in a pass of the first
/// is not in the next, and need not. The last one is wider: what the border's pyramids hold at every attempt
/// wanders along a surface otherwise.
constexpr int kRuns = 4;
constexpr int kRaisingRuns = 3;  ///< each time
/// Sine of 30 degrees: up to there the last step has a wider run, too. Beyond, too many elements have no
/// room.
constexpr double kMostWidened = 0.5;
/// Quality is raised in steps of this, and of a little more before the goal: where nearly all elements are
/// far from it, the search does not know where to begin.
constexpr double kRaise = 1.2;
constexpr double kLastRaise = 1.1;
/// Sine of 40 degrees: few elements have more at all their angles. Who asks for it wants the many to be
/// better, and the last step has all its runs however many are short of it.
constexpr double kMostReached = 0.643;

void start_trace(const Mesh& mesh, Trace& trace) {
    const auto number = [](std::vector<std::uint32_t>& list, std::size_t count) {
        list.resize(count);
        std::iota(list.begin(), list.end(), 0u);
    };
    number(trace.node, mesh.node_count());
    for (std::size_t t = 0; t < kElementTypes; ++t) number(trace.element[t], mesh.elements[t].size());
    number(trace.facet, mesh.facets.size());
}

bool holds_open(const Zone& zone, const std::vector<std::uint8_t>& is_open, const Trace& trace) {
    return std::any_of(zone.mesh_node.begin(), zone.mesh_node.end(), [&](NodeId node) {
        return node != kNone && trace.node[node] != kNone && is_open[trace.node[node]] != 0;
    });
}

/// Those of surfaces whose facets may change: at a held one nodes stay, and no facet gets another surface.
std::vector<Tip> without_held(std::vector<Tip> tips, const std::vector<std::uint8_t>* held) {
    const auto is_held = [held](const Tip& tip) {
        return std::any_of(tip.surfaces.begin(), tip.surfaces.end(),
                           [held](std::uint32_t surface) { return (*held)[surface] != 0; });
    };
    if (held != nullptr) tips.erase(std::remove_if(tips.begin(), tips.end(), is_held), tips.end());
    return tips;
}

/// Improves a mesh, run after run.
class Session {
  public:
    /// `trace` may be null; it is brought up to date.
    Session(Mesh mesh, const tape::BoundModel& model, const Options& options, Trace* trace)
        : mesh_(std::move(mesh)),
          frame_(make_frame(model, options.level)),
          surfaces_(model, options.level),
          tips_(without_held(
              find_tips(model, options.poles != nullptr ? *options.poles : no_poles_, options.level),
              options.held)),
          options_(options),
          trace_(trace) {
        if (options.leaves != nullptr && !options.leaves->is_uniform()) frame_.leaves = options.leaves;
        mesh_.model_dimension = {};  // nodes come and go
    }

    /// Until all is good, but for what nothing helps; `loosens`: so it stays.
    void make_good(bool loosens) {
        run_until_good(loosens);
        settle();
    }

    /// From one quality to a higher one, but for what nothing helps. `widens`: with a wider zone at last.
    void raise(double from, double to, bool widens) {
        frame_.on_lattice = false;
        run_until_raised(from, to, widens);
        settle();
    }

    /// The same for good quality only, if all elements but cubes have been split.
    void mend() {
        cuts_quads_ = true;
        raise(kGoodQuality, kGoodQuality, false);
    }

    /// After the last raise().
    void loosen() {
        if (!(options_.merge_distance > 0)) return;
        frame_.on_lattice = false;
        if (std::optional<Zone> zone = open(kLoosenBelow, false, false)) {
            Improver(*zone, surfaces_, options_, {kGoodQuality, false, 0}).loosen(counters_);
            close(*zone);
        }
        settle();
    }

    void raise_in_steps() {
        double step = kGoodQuality;
        while (step < options_.goal) {
            const double from = step;
            step *= kRaise;
            if (step * kLastRaise > options_.goal) step = options_.goal;
            raise(from, step, !(step < options_.goal) && step < kMostWidened);
        }
        loosen();
        counters_.below_goal = count_below(mesh_, frame_, options_.goal, options_.threads);
    }

    Mesh finish(Counters& counters) {
        counters = counters_;
        return std::move(mesh_);
    }

  private:
    void run_until_good(bool loosens) {
        for (int run = 0; run < kRuns; ++run) {
            std::optional<Zone> zone = open(kGoodQuality, false, run + 1 == kRuns);
            if (!zone) return;
            if (run == 0) take_out_crumbs(*zone);
            Improver improver(*zone, surfaces_, options_, {kGoodQuality, run == 0, 0});
            make_passes(improver, run);
            // After the first run features may be merged, which may leave room.
            const bool may_help = run == 0 && options_.merge_distance > 0;
            const bool done = improver.is_done() || (improver.is_hopeless() && !may_help) || run + 1 == kRuns;
            take_out_crumbs(*zone);
            if (done && loosens && options_.merge_distance > 0) improver.loosen(counters_);
            close(*zone);
            if (done) return;
        }
    }

    void run_until_raised(double from, double to, bool widens) {
        Options options = options_;
        options.merge_distance = 0;
        const int runs = kRaisingRuns + (widens ? 1 : 0);
        for (int run = 0; run < runs; ++run) {
            // Most elements are mended without their neighbours inside, and hexahedra are what people want.
            std::optional<Zone> zone = open(to, run == 0 && !cuts_quads_, run == kRaisingRuns);
            if (!zone) return;
            Improver improver(*zone, surfaces_, options, {to, false, from});
            make_passes(improver, run);
            const bool persists = to > kMostReached && !(to < options_.goal);
            const bool done = improver.is_done() || (improver.is_hopeless() && !persists);
            close(*zone);
            if (done) return;
        }
    }

    /// None if there is nothing to do, or too little is known of the mesh.
    std::optional<Zone> open(double least, bool leaves_cubes, bool is_wide) {
        if (counters_.reached_open) return std::nullopt;
        const ZoneOptions options = {options_.held, options_.slabs, least,           leaves_cubes,
                                     is_wide,       cuts_quads_,    options_.threads};
        Zone zone = open_zone(mesh_, frame_, surfaces_, tips_, options, known_);
        const bool is_open = options_.is_open != nullptr && holds_open(zone, *options_.is_open, *trace_);
        counters_.reached_open = counters_.reached_open || is_open;
        if (zone.tetrahedra.empty() || is_open) {
            drop_zone(zone, known_);
            return std::nullopt;
        }
        counters_.zone_elements += zone.tetrahedra.size() + zone.pyramids.size();
        return zone;
    }

    void take_out_crumbs(Zone& zone) {
        // What hangs at a periodic plane is left to the run on the whole mesh, which tells of it.
        const double most = options_.slabs == nullptr ? kScrapVolume : kCrumbVolume;
        const Crumbs found = remove_crumbs(zone, most, options_.threads);
        Crumbs& all = counters_.crumbs;
        all.count += found.count;
        all.largest = std::max(all.largest, found.largest);
        if (found.first && !all.first) all.first = frame_.origin + frame_.cell * *found.first;
    }

    void make_passes(Improver& improver, int run) {
        const int passes = improver.pass_count();
        for (int pass = 0; pass < passes && (pass == 0 || !improver.is_done()); ++pass)
            improver.pass(pass, run > 0 ? Effort::kLookAhead : Effort::kPlain, counters_);
    }

    void close(const Zone& zone) {
        mesh_ = close_zone(std::move(mesh_), frame_, zone, trace_, known_);
        frame_.on_lattice = false;
    }

    /// Zones leave what they have replaced in the mesh, since to move all behind it takes longer than most of
    /// them. Nothing is known of the mesh afterwards.
    void settle() {
        if (known_.gone.facet.empty()) return;  // no zone has been opened
        if (options_.followed != nullptr)
            *options_.followed = without(*options_.followed, known_.gone.element[0]);
        mesh_ = remove_gone(std::move(mesh_), std::move(known_.gone), options_.threads, trace_);
        known_ = {};
    }

    const std::vector<tape::Pole> no_poles_;
    Mesh mesh_;
    CellFrame frame_;
    const Surfaces surfaces_;
    const std::vector<Tip> tips_;
    const Options& options_;
    Trace* trace_;
    Counters counters_;
    Known known_;
    bool cuts_quads_ = false;
};

}  // namespace

CellFrame make_frame(const tape::BoundModel& model, int level) {
    CellFrame frame{};
    frame.origin = {model.origin[0], model.origin[1], model.origin[2]};
    frame.cell = std::ldexp(model.side, -level);
    frame.per_cell = 1 / frame.cell;
    frame.level = level;
    return frame;
}

double quality_of_angle(double degrees) { return expression_sin(degrees * kRadians, 0); }

Mesh improve(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters* counters,
             Trace* trace) {
    Trace own;
    if (trace == nullptr && options.is_open != nullptr) trace = &own;
    if (trace != nullptr) start_trace(mesh, *trace);
    Session session(std::move(mesh), model, options, trace);
    session.make_good(!(options.goal > kGoodQuality));
    Counters local;
    return session.finish(counters != nullptr ? *counters : local);
}

Mesh mend_parts(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters& counters) {
    Options keeping = options;
    keeping.keeps_loose = true;
    Session session(std::move(mesh), model, keeping, nullptr);
    session.mend();
    Counters added;
    mesh = session.finish(added);
    counters.zone_elements += added.zone_elements;
    return mesh;
}

Mesh raise(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters& counters,
           Trace* trace) {
    Session session(std::move(mesh), model, options, trace);
    session.raise_in_steps();
    Counters added;
    mesh = session.finish(added);
    counters.zone_elements += added.zone_elements;
    counters.reached_open = added.reached_open;
    counters.loosened = added.loosened;
    counters.below_goal = added.below_goal;
    return mesh;
}

}  // namespace mortise::improve
