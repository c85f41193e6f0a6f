// What other programs may do wrong with the headers of include/mortise: each an Error, never a crash.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "mortise/check.hpp"
#include "mortise/io.hpp"
#include "mortise/mesher.hpp"
#include "tests/io/folder.hpp"

using namespace mortise;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr auto kNowhere = 4'000'000'000u;

/// A ball (node 0), a turned ball (nodes 1 and 2) and their union (node 3).
Model good_model() {
    Model model;
    const auto ball = model.add_primitive(sphere(1));
    const auto other = model.add_primitive(sphere(0.5));
    const auto moved = model.add_transform({1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}, other);
    Region region;
    region.name = "a";
    region.root = model.add_operation(CsgNode::Op::kUnion, {ball, moved});
    model.regions.push_back(region);
    return model;
}

MeshOptions coarse() {
    MeshOptions options;
    options.level = 3;
    return options;
}

/// The message of an error with this code; empty: there was none.
std::string refusal(ExitCode code, const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        CHECK(error.code() == code);
        return error.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Takes whatever comes.
struct Sink : MeshSink {
    void begin(const MeshTotals&, const Mesh&) override {}
    void add(const Mesh&, const std::vector<float>&) override {}
};

struct BadModel {
    const char* message;
    std::function<void(Model&)> spoil;
};

Primitive raw(Primitive::Kind kind, double radius) {
    Primitive primitive;
    primitive.kind = kind;
    primitive.radius = radius;
    return primitive;
}

const BadModel kBadModels[] = {
    {"model: region 0: its root is node 77", [](Model& m) { m.regions[0].root = 77; }},
    {"region 0: max_size is -1", [](Model& m) { m.regions[0].max_size = -1; }},
    {"model: model node 3: child 5", [](Model& m) { m.nodes[3].children = {5}; }},
    {"model node 3: child 4000000000",
     [](Model& m) {
         m.nodes[3].children = {0, kNowhere};
     }},
    {"model node 3: child 3", [](Model& m) { m.nodes[3].children = {3}; }},
    {"model node 2: child 3", [](Model& m) { m.nodes[2].children = {3}; }},
    {"model node 2: it has 0 children", [](Model& m) { m.nodes[2].children.clear(); }},
    {"model node 1: a primitive has no children", [](Model& m) { m.nodes[1].children = {0}; }},
    {"model node 3: unknown operation 99", [](Model& m) { m.nodes[3].op = static_cast<CsgNode::Op>(99); }},
    {"primitive: unknown kind 99",
     [](Model& m) { m.nodes[0].primitive.kind = static_cast<Primitive::Kind>(99); }},
    {"model node 0: sphere: radius is -1", [](Model& m) { m.nodes[0].primitive.radius = -1; }},
    {"model node 1: sphere: radius is nan", [](Model& m) { m.nodes[1].primitive.radius = kNan; }},
    {"torus: major radius is 0", [](Model& m) { m.nodes[0].primitive = raw(Primitive::Kind::kTorus, 1); }},
    {"it has no planes", [](Model& m) { m.nodes[0].primitive = raw(Primitive::Kind::kConvex, 1); }},
    {"rounded solid: it has no balls",
     [](Model& m) { m.nodes[0].primitive = raw(Primitive::Kind::kRounded, 1); }},
    {"at least four triangles",
     [](Model& m) { m.nodes[0].primitive = raw(Primitive::Kind::kPolyhedron, 1); }},
    {"rounded solid: unknown shape 9",
     [](Model& m) {
         RoundedSolid solid;
         solid.shape = static_cast<RoundedSolid::Shape>(9);
         solid.balls = {{{0, 0, 0}, 1}};
         m.nodes[0].primitive.kind = Primitive::Kind::kRounded;
         m.nodes[0].primitive.rounded = std::make_shared<const RoundedSolid>(solid);
     }},
    {"model node 2: transform: an entry of the matrix is nan", [](Model& m) { m.nodes[2].map[3] = kNan; }},
    {"model node 2: transform: the matrix is singular", [](Model& m) { m.nodes[2].map[0] = 0; }},
    {"model node 3: max_size is nan", [](Model& m) { m.nodes[3].max_size = kNan; }},
    {"model node 3: surface_size is -2", [](Model& m) { m.nodes[3].surface_size = -2; }},
    {"model node 3: its bounds along y",
     [](Model& m) {
         m.nodes[3].bounds = Box3{{0, kNan, 0}, {1, 1, 1}};
     }},
    {"its clip is empty along z",
     [](Model& m) {
         m.clip = Box3{{0, 0, 1}, {1, 1, 1}};
     }},
    {"its clip is empty along x",
     [](Model& m) {
         m.clip = Box3{{kNan, 0, 0}, {1, 1, 1}};
     }},
    {"size hint 0: node 99 does not exist; there are 4",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kMeeting, {}, {{0}, {99}}, 0, {}});
     }},
    {"size hint 0: node 3 is not a primitive",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kMeeting, {}, {{3}}, 0, {}});
     }},
    {"size hint 0: it has 1 groups",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kGap, {}, {{0}}, 0, {}});
     }},
    {"size hint 0: it has no groups",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kMeeting, {}, {}, 0, {}});
     }},
    {"size hint 0: unknown kind 7",
     [](Model& m) {
         m.hints.push_back({static_cast<SizeHint::Kind>(7), {}, {}, 0, {}});
     }},
    {"size hint 0: point: coordinate is nan",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kPoint, {0, kNan, 0}, {}, 0, {}});
     }},
    {"size hint 0: max_size is -1",
     [](Model& m) {
         m.hints.push_back({SizeHint::Kind::kPoint, {}, {}, -1, {}});
     }},
    {"periodic pair 0: node 98 does not exist",
     [](Model& m) {
         m.periodic.push_back({{0}, {98}, "p", {}});
     }},
};

}  // namespace

TEST_CASE("a model with wrong fields is refused by all that take one") {
    CHECK(refusal(ExitCode::kInput, [] { check_model(good_model()); }).empty());
    for (const BadModel& bad : kBadModels) {
        CAPTURE(bad.message);
        Model model = good_model();
        bad.spoil(model);
        Sink sink;
        const std::pair<const char*, std::function<void()>> calls[] = {
            {"check_model", [&] { check_model(model); }},
            {"summarize", [&] { summarize(model); }},
            {"generate", [&] { generate_mesh(model, coarse()); }},
            {"stream", [&] { Mesher().stream(model, coarse(), sink); }}};
        for (const auto& [name, call] : calls) {
            CAPTURE(name);
            const std::string message = refusal(ExitCode::kInput, call);
            CAPTURE(message);
            CHECK(contains(message, bad.message));
            CHECK(message.find('\n') == std::string::npos);
        }
    }
}

TEST_CASE("options out of range are wrong usage") {
    const std::pair<const char*, std::function<void(MeshOptions&)>> cases[] = {
        {"level 12", [](MeshOptions& o) { o.level = 12; }},
        {"level and size (--level, --size) are both given; leave one of the two out",
         [](MeshOptions& o) { o.size = 0.1; }},
        {"smooth (--smooth) -5 is out of range; use 0 to 100 rounds", [](MeshOptions& o) { o.smooth = -5; }},
        {"smooth (--smooth) 101", [](MeshOptions& o) { o.smooth = 101; }},
        {"threads -3", [](MeshOptions& o) { o.threads = -3; }},
        {"work-group size -1", [](MeshOptions& o) { o.work_group_size = -1; }},
        {"smallest cell size 1 is above",
         [](MeshOptions& o) {
             o.size_min = 1;
             o.size_max = 0.1;
         }},
        {"size_min (--size-min) nan", [](MeshOptions& o) { o.size_min = NAN; }},
        {"size_max (--size-max) -1", [](MeshOptions& o) { o.size_max = -1; }},
        {"size of 'ball' 0",
         [](MeshOptions& o) {
             o.named_sizes = {{"ball", 0}};
         }},
        {"size around (0, 0, 0) -1",
         [](MeshOptions& o) {
             o.sizes = {{{0, 0, 0}, -1, 1}};
         }},
        {"growth -1 of the size around (1, 2, 3)",
         [](MeshOptions& o) {
             o.sizes = {{{1, 2, 3}, 0.1, -1}};
         }},
        {"refine (--refine) 99 is out of range; use 0 to 18 levels", [](MeshOptions& o) { o.refine = 99; }},
        {"interior_coarsening (--interior-coarsening) 99",
         [](MeshOptions& o) { o.interior_coarsening = 99; }},
        {"12 works within refine (--refine), which is 0", [](MeshOptions& o) { o.curvature_elements = 12; }},
        {"curvature_elements (--curvature-elements) 2 is out of range; use a number from 3",
         [](MeshOptions& o) {
             o.refine = 1;
             o.curvature_elements = 2;
         }},
        {"pieces 0", [](MeshOptions& o) { o.pieces = 0; }},
        {"the box is not finite along x",
         [](MeshOptions& o) {
             o.box = Box3{{NAN, 0, 0}, {1, 1, 1}};
         }},
        {"periodic axes 'xw': expected some of the letters x, y and z",
         [](MeshOptions& o) { o.periodic = "xw"; }},
        {"periodic axes 'xyx'", [](MeshOptions& o) { o.periodic = "xyx"; }},
        {"layers do not go with periodic faces",
         [](MeshOptions& o) {
             o.periodic = "x";
             o.layers.count = 2;
         }},
        {"the box is empty along y",
         [](MeshOptions& o) {
             o.box = Box3{{0, 1, 0}, {1, 1, 1}};
         }},
    };
    for (const auto& [message, spoil] : cases) {
        CAPTURE(message);
        MeshOptions options = coarse();
        spoil(options);
        CHECK(contains(refusal(ExitCode::kUsage, [&] { generate_mesh(good_model(), options); }), message));
        Sink sink;
        CHECK(contains(refusal(ExitCode::kUsage, [&] { Mesher().stream(good_model(), options, sink); }),
                       message));
    }
    MeshOptions short_of_memory = coarse();
    short_of_memory.progress = [](const char*, double) -> bool { throw std::bad_alloc(); };
    CHECK(contains(refusal(ExitCode::kDevice, [&] { generate_mesh(good_model(), short_of_memory); }),
                   "out of memory"));
    MeshOptions repeats = coarse();
    repeats.periodic = "z";
    CHECK(contains(refusal(ExitCode::kUsage, [&] { generate_mesh(good_model(), repeats); }),
                   "periodic faces are those of a box that cuts the solid"));
    Sink unused;
    CHECK(contains(refusal(ExitCode::kUsage, [&] { Mesher().stream(good_model(), repeats, unused); }),
                   "cannot have periodic faces"));
    CHECK(contains(refusal(ExitCode::kUsage, [&] { Mesher().estimate(good_model(), repeats); }),
                   "periodic faces are those of a box"));
    CHECK(contains(refusal(ExitCode::kUsage, [] { Mesher("", -1).generate(good_model(), coarse()); }),
                   "work-group size -1"));
}

TEST_CASE("cells larger than the model are told of, much larger ones refused") {
    const Model ball = parse_model("sphere(r = 5, $fn = 0);", "csg", "ball");
    MeshOptions options;
    options.size = 1e9;
    CHECK(contains(refusal(ExitCode::kUsage, [&] { generate_mesh(ball, options); }),
                   "cells of size 1e+09 are larger than the model, which is 10"));
    options.size = 12;
    MeshReport report;
    generate_mesh(ball, options, &report);
    REQUIRE(report.warnings.size() == 1);
    CHECK(contains(report.warnings[0], "are larger than the model"));
    options.strict = true;
    CHECK(contains(refusal(ExitCode::kMeshing, [&] { generate_mesh(ball, options); }), "strict"));
    options = coarse();
    CHECK(generate_mesh(ball, options, &report).element_count() > 0);
    CHECK(report.warnings.empty());
}

TEST_CASE("sizes whose powers double precision does not have are refused") {
    for (const char* text : {"cube(1e-60);", "sphere(r = 1e-90, $fn = 0);", "cube(1e-120);"}) {
        const Model speck = parse_model(text, "csg", "speck");
        CHECK(contains(refusal(ExitCode::kInput, [&] { generate_mesh(speck, coarse()); }),
                       "choose other units"));
    }
    const Model small = parse_model("sphere(r = 1e-40, $fn = 0);", "csg", "small");
    CHECK(generate_mesh(small, coarse()).element_count() > 0);
}

TEST_CASE("a limit of memory is for meshes in parts alone") {
    MeshOptions options = coarse();
    options.memory = 1;
    CHECK(generate_mesh(good_model(), options).element_count() > 0);
    Sink sink;
    CHECK(contains(refusal(ExitCode::kDevice, [&] { Mesher().stream(good_model(), options, sink); }),
                   "and 1 bytes are allowed"));
}

TEST_CASE("a format is named with or without dot, in any case of letters") {
    for (const char* format : {"csg", ".csg", "CSG", ".Csg"})
        CHECK(parse_model("cube(1);", format, "text").regions.size() == 1);
    for (const char* format : {"", ".", "step", "..csg", "a.csg"}) {
        CAPTURE(format);
        CHECK(contains(refusal(ExitCode::kInput, [&] { parse_model("cube(1);", format, "text"); }),
                       "unknown model format"));
    }
}

TEST_CASE("a warning of one surface says one") {
    const Model model =
        parse_model("cube(1); translate([0.2, 0.2, 1e-6]) cube([0.5, 0.5, 1.5]);", "csg", "text");
    MeshReport report;
    generate_mesh(model, coarse(), &report);
    REQUIRE(report.warnings.size() == 1);
    CHECK(contains(report.warnings[0], "1 surface that lies within"));
}

TEST_CASE("a mesher that has been moved from refuses work until it is assigned to") {
    Mesher first;
    Mesher second = std::move(first);
    Sink sink;
    CHECK(contains(refusal(ExitCode::kUsage, [&] { first.generate(good_model(), coarse()); }), "moved"));
    CHECK(contains(refusal(ExitCode::kUsage, [&] { first.stream(good_model(), coarse(), sink); }), "moved"));
    CHECK(contains(refusal(ExitCode::kUsage, [&] { first.recycle(Mesh{}); }), "moved"));
    first = std::move(second);
    CHECK(first.generate(good_model(), coarse()).element_count() > 0);
}

TEST_CASE("a mesher does one thing at a time") {
    Mesher mesher;
    MeshOptions options = coarse();
    std::string inner;
    options.progress = [&](const char*, double) {
        inner = refusal(ExitCode::kUsage, [&] { mesher.generate(good_model(), coarse()); });
        return true;
    };
    CHECK(mesher.generate(good_model(), options).element_count() > 0);
    CHECK(contains(inner, "at work already"));
    CHECK(mesher.generate(good_model(), coarse()).element_count() > 0);
}

TEST_CASE("a stopped run can be told from a failed one") {
    MeshOptions options = coarse();
    options.progress = [](const char* stage, double) { return std::string(stage) != "extract"; };
    CHECK_THROWS_AS(generate_mesh(good_model(), options), Interrupted);
    CHECK(refusal(ExitCode::kMeshing, [&] { generate_mesh(good_model(), options); }) == "interrupted");
}

TEST_CASE("files of parts: calls in the wrong order leave no file") {
    const Folder folder;
    const std::string path = folder.path / "a.vtu";
    const auto refused = [](const std::function<void()>& call, const char* part) {
        CAPTURE(part);
        CHECK(contains(refusal(ExitCode::kUsage, call), part));
    };
    // The stream lives on: a program that does not catch the error ends without its destructor.
    {
        MeshFileStream file(path);
        refused([&] { file.commit(); }, "before begin()");
        CHECK(std::filesystem::is_empty(folder.path));
        refused([&] { file.commit(); }, "after the end");
        refused([&] { file.begin({}, {}); }, "after the end");
    }
    {
        MeshFileStream file(path);
        refused([&] { file.add({}, {}); }, "before begin()");
        CHECK(std::filesystem::is_empty(folder.path));
    }
    {
        MeshFileStream file(path);
        MeshTotals totals;
        totals.nodes = 4;
        file.begin(totals, {});
        refused([&] { file.commit(); }, "before all nodes and elements");
        CHECK(std::filesystem::is_empty(folder.path));
    }
    {
        MeshFileStream file(path);
        file.begin({}, {});
        Mesh part;
        part.points = {0, 0, 0};
        part.model_dimension = {3};
        refused([&] { file.add(part, {}); }, "more than begin()");
        CHECK(std::filesystem::is_empty(folder.path));
    }
    MeshFileStream file(path);
    Mesher().stream(good_model(), coarse(), file);
    file.commit();
    refused([&] { file.commit(); }, "after the end");
    CHECK(check_mesh(read_mesh(path)).valid());
}

TEST_CASE("shapes of a mesh with wrong indices are refused, and its check tells them") {
    const Mesh mesh = generate_mesh(good_model(), coarse());
    Mesh outside = mesh;
    outside.block(ElementType::kTetrahedron).nodes.front() = kNowhere;
    Mesh shorter = mesh;
    shorter.block(ElementType::kTetrahedron).nodes.resize(3);
    for (const Mesh* bad : {&outside, &shorter}) {
        CHECK_FALSE(check_mesh(*bad).valid());
        CHECK(contains(refusal(ExitCode::kMeshing, [&] { element_quality(*bad); }), "see check_mesh"));
        CHECK(contains(refusal(ExitCode::kMeshing, [&] { scaled_jacobians(*bad); }), "see check_mesh"));
    }
}
