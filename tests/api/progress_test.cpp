// MeshOptions::progress within stages: told again and again, without a trace in the mesh; stopping there.
#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>

#include "mortise/mesher.hpp"

namespace {

using namespace mortise;
using Clock = std::chrono::steady_clock;

/// A sheet that bends everywhere: a second or two of extraction, improvement and report.
Model long_job() {
    return parse_model("abs(sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)) - 0.4", "formula",
                       "gyroid.formula");
}

MeshOptions long_options() {
    MeshOptions options;
    options.level = 5;
    options.box = Box3{{-4, -4, -4}, {4, 4, 4}};
    options.quality = true;
    options.min_angle = 25;
    options.threads = 2;
    return options;
}

bool is_same(const Mesh& a, const Mesh& b) {
    bool same = a.points == b.points && a.facets.nodes == b.facets.nodes;
    for (std::size_t t = 0; t < kElementTypes; ++t) same = same && a.elements[t].nodes == b.elements[t].nodes;
    return same;
}

/// As a caller's own.
struct Refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace

TEST_CASE("progress is told again while a stage lasts, by the thread that meshes") {
    const Model model = long_job();
    Mesher mesher;
    MeshOptions options = long_options();
    const Mesh expected = mesher.generate(model, options);
    std::map<std::string, int> calls;
    double last = 0;
    options.progress = [&, owner = std::this_thread::get_id()](const char* stage, double progress) {
        CHECK((std::this_thread::get_id() == owner));
        CHECK(progress >= last);
        last = progress;
        ++calls[stage];
        return true;
    };
    CHECK(is_same(mesher.generate(model, options), expected));
    for (const char* const stage : {"extract", "improve", "raise", "quality"}) {
        CAPTURE(stage);
        CHECK(calls[stage] > 1);
    }

    // It is asked within stages, too: the run ends there, and the next one is as ever.
    for (const std::string stop : {"extract", "improve", "raise", "quality"}) {
        CAPTURE(stop);
        int seen = 0;
        Clock::time_point stopped;
        options.progress = [&](const char* stage, double) {
            if (stage != stop || ++seen < 2) return true;
            stopped = Clock::now();
            return false;
        };
        CHECK_THROWS_AS(mesher.generate(model, options), Interrupted);
        const std::chrono::duration<double> took = Clock::now() - stopped;
        CHECK(seen == 2);
        MESSAGE(stop << " ended after " << took.count() << " s");
        CHECK(took.count() < 5);  // a tenth of that on a machine with nothing else to do
    }
    options.progress = [](const char* stage, double) -> bool {
        static int seen = 0;
        if (std::string(stage) == "improve" && ++seen == 2) throw Refusal(stage);
        return true;
    };
    CHECK_THROWS_AS(mesher.generate(model, options), Refusal);
    options.progress = nullptr;
    CHECK(is_same(mesher.generate(model, options), expected));
}

TEST_CASE("what is called for progress may mesh, check and write with another mesher") {
    const Model model = long_job();
    MeshOptions options = long_options();
    options.quality = false;
    int inner = 0;
    options.progress = [&](const char* stage, double) {
        if (std::string(stage) == "improve" && inner++ == 1) {
            MeshOptions small;
            small.level = 3;
            small.box = Box3{{-3, -3, -3}, {3, 3, 3}};
            CHECK(Mesher().generate(model, small).element_count() > 0);
        }
        return true;
    };
    CHECK(Mesher().generate(model, options).element_count() > 0);
    CHECK(inner > 1);
}
