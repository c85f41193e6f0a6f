// The models in assets/models, and all files of the corpora where they are present.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "host/common/constants.hpp"
#include "tests/corpora.hpp"
#include "tests/model/membership.hpp"

namespace fs = std::filesystem;
using namespace mortise;

namespace {
/// A model sampled at the centers of an n³ grid over a cube.
struct Samples {
    int n;
    double step;
    std::vector<char> solid;

    Samples(const Model& model, const Vec3& center, double half, int count)
        : n(count), step(2 * half / count), solid(static_cast<std::size_t>(count) * count * count) {
        std::size_t index = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                for (int k = 0; k < n; ++k) {
                    const auto at = [&](std::size_t axis, int cell) {
                        return center[axis] - half + (cell + 0.5) * step;
                    };
                    solid[index++] = test::region_at(model, {at(0, i), at(1, j), at(2, k)}) == 1 ? 1 : 0;
                }
            }
        }
    }
    /// Pieces by shared cell faces.
    int components() const {
        std::vector<char> left = solid;
        int pieces = 0;
        for (std::size_t seed = 0; seed < left.size(); ++seed) {
            if (left[seed] == 0) continue;
            ++pieces;
            std::vector<std::size_t> pending = {seed};
            left[seed] = 0;
            while (!pending.empty()) {
                const std::size_t cell = pending.back();
                pending.pop_back();
                std::size_t stride = 1;
                for (int axis = 0; axis < 3; ++axis, stride *= static_cast<std::size_t>(n)) {
                    const std::size_t along = cell / stride % static_cast<std::size_t>(n);
                    const auto visit = [&](std::size_t other) {
                        if (left[other] == 0) return;
                        left[other] = 0;
                        pending.push_back(other);
                    };
                    if (along > 0) visit(cell - stride);
                    if (along + 1 < static_cast<std::size_t>(n)) visit(cell + stride);
                }
            }
        }
        return pieces;
    }
    /// No solid on the boundary of the sampled cube: the solid is bounded by it.
    bool clear_of_border() const {
        std::size_t index = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                for (int k = 0; k < n; ++k, ++index) {
                    const bool border = i == 0 || j == 0 || k == 0 || i == n - 1 || j == n - 1 || k == n - 1;
                    if (border && solid[index] != 0) return false;
                }
            }
        }
        return true;
    }
};

/// Volume by a low-discrepancy sequence: unlike a grid's, its points do not line up with flat faces.
double sampled_volume(const Model& model, const Vec3& center, double half) {
    // Powers of the inverse of the real root of x⁴ = x + 1.
    constexpr double kRatio = 0.8191725133961645;
    constexpr Vec3 kSteps = {kRatio, kRatio * kRatio, kRatio * kRatio * kRatio};
    constexpr int kPoints = 200000;
    int count = 0;
    for (int i = 1; i <= kPoints; ++i) {
        Vec3 point{};
        for (std::size_t k = 0; k < 3; ++k)
            point[k] = center[k] + half * (2 * std::fmod(i * kSteps[k], 1.0) - 1);
        if (test::region_at(model, point) == 1) ++count;
    }
    return 8 * half * half * half * count / kPoints;
}

}  // namespace

TEST_CASE("the objects in assets/models are single, bounded solids of the expected volume") {
    struct Asset {
        const char* name;
        Vec3 center;
        double half;
        double volume;
    };
    // Housing: flange and shell less cavity, bores and bolt holes. The star's and the cylinders' volumes:
    // quadrature outside this program.
    const Asset assets[] = {
        {"block", {0, 0, 0}, 3, 24},
        {"housing",
         {0, 0, 1.5},
         4.2,
         48 * 0.5 + 24 * 2.5 - 15 * 2.5 - kPi * 0.75 * 0.75 - 4 * kPi * 0.0625 * 0.5},
        {"cyl_cyl_int", {0, 0, 0}, 1.2, 3.6664},
        {"bracket", {2, 1, 1.5}, 2.2, 12 - 3 * kPi * 0.16},
        {"object_x", {0, 0, 0}, 2.7, 11},
        {"star", {0, 0, 0}, 2.6, 7.4868},
    };
    for (const Asset& asset : assets) {
        CAPTURE(asset.name);
        const Model model =
            read_model(std::string(MORTISE_SOURCE_DIR) + "/assets/models/" + asset.name + ".csg");
        CHECK(model.regions.size() == 1);
        CHECK(model.regions[0].name == asset.name);
        CHECK(model.warnings.empty());
        const Samples samples(model, asset.center, asset.half, 60);
        CHECK(samples.components() == 1);
        CHECK(samples.clear_of_border());
        CHECK(sampled_volume(model, asset.center, asset.half) ==
              doctest::Approx(asset.volume).epsilon(0.005));
    }
}

namespace {
/// The words whose refusal is known and allowed.
constexpr std::array<const char*, 6> kNotYet = {"polyhedron",   "resize", "roof",
                                                "path_extrude", "tube",   "gencyl"};

std::string text_of(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

/// Whether the text without '#' comments starts with another word than Netgen requires.
bool lacks_first_word(const std::string& text) {
    std::istringstream lines(text);
    std::string line;
    while (std::getline(lines, line)) {
        line = line.substr(0, line.find('#'));
        if (!is_blank(line)) return line.find("algebraic3d") == std::string::npos;
    }
    return true;
}

/// Whether the message says that a solid is not defined, and the text indeed does not define it.
bool lacks_solid(const std::string& text, const std::string& message) {
    const std::size_t end = message.find("' is not defined");
    if (end == std::string::npos) return false;
    const std::size_t begin = message.rfind('\'', end - 1) + 1;
    return text.find("solid " + message.substr(begin, end - begin)) == std::string::npos;
}

}  // namespace

TEST_CASE("every file of the corpora is read, or refused for a known reason") {
    const fs::path root = test::corpora_folder();
    const char* sets[] = {"netgen-tutorials", "ngsolve-pde",          "nmag", "finmag", "mpt-calculator",
                          "prusa-i3/csg",     "openscad-examples/csg"};
    for (const char* set : sets) {
        if (!fs::is_directory(root / set)) {
            std::cout << "corpus " << set << ": skipped, no such folder\n";
            continue;
        }
        std::vector<fs::path> paths;
        for (const auto& entry : fs::recursive_directory_iterator(root / set)) {
            const fs::path extension = entry.path().extension();
            if (extension == ".geo" || extension == ".csg") paths.push_back(entry.path());
        }
        std::sort(paths.begin(), paths.end());
        int read = 0;
        int unsupported = 0;
        int invalid = 0;
        for (const fs::path& path : paths) {
            try {
                const Model model = read_model(path.string());
                CHECK_FALSE(model.regions.empty());
                CHECK_NOTHROW(check_model(model));
                ++read;
            } catch (const Error& error) {
                const std::string message = error.what();
                CAPTURE(message);
                // The corpora lack the files that some models import.
                const bool lacks_file =
                    error.code() == ExitCode::kFiles && (message.find("'import': ") != std::string::npos ||
                                                         message.find("'surface': ") != std::string::npos);
                CHECK((error.code() == ExitCode::kInput || lacks_file));
                const bool is_shadow = message.find("'projection': ") != std::string::npos &&
                                       message.find("is not supported") != std::string::npos;
                const bool known =
                    is_shadow || std::any_of(kNotYet.begin(), kNotYet.end(), [&](const char* word) {
                        return message.find("'" + std::string(word) + "' is not supported yet") !=
                               std::string::npos;
                    });
                // Files without a solid in them, without a file they need, and fragments that lack the first
                // word or a solid, are invalid.
                const std::string text = text_of(path);
                const bool is_geo = path.extension() == ".geo";
                const bool only_flat = message.find("the file holds 2D shapes only") != std::string::npos;
                const bool is_invalid = is_blank(text) || lacks_file || only_flat ||
                                        (is_geo && (lacks_first_word(text) || lacks_solid(text, message)));
                CHECK((known || is_invalid));
                ++(known ? unsupported : invalid);
            }
        }
        std::cout << "corpus " << set << ": " << paths.size() << " files, " << read << " read, "
                  << unsupported << " refused as not supported yet, " << invalid << " refused as invalid\n";
    }
}
