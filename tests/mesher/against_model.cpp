#include "tests/mesher/against_model.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/mesher/membership_scan.hpp"

namespace mortise::test {

constexpr int kLines = 32;  ///< columns per direction: about one sample per cell

std::optional<Meshed> mesh_unless_empty(const Model& model, const MeshOptions& options) {
    try {
        return mesh_and_check(model, options);
    } catch (const Error& error) {
        const bool is_empty =
            error.code() == ExitCode::kInput && std::string(error.what()).find("empty") != std::string::npos;
        const bool is_tiny = std::string(error.what()).find("too far from the origin") != std::string::npos;
        if (!is_empty && !is_tiny) FAIL_CHECK(std::string(error.what()));
        return std::nullopt;
    }
}

/// The volume between the true surface and the mesh's, per area and cell size, that chords and unresolved
/// cells may cost. Over 2000 seeds the largest was 0.08, for bodies a few cells thick.
constexpr double kSurfaceShare = 0.1;

/// Samples are jittered one per box, so only boxes that the boundary cuts add noise: about area / step².
static bool is_volume(const ScanResult& scan, double area, std::size_t region, double volume) {
    const double step = std::cbrt(scan.sample_volume);
    const double spread = 0.5 * scan.sample_volume * std::sqrt(area / (step * step) + 1);
    return std::fabs(volume - scan.model_volume[region]) <= scan.wrong_volume + 6 * spread;
}

void compare_with_model(const Model& model, const Meshed& meshed) {
    const MeshReport& report = meshed.report;
    const ScanResult scan = scan_membership(model, meshed.mesh, report.root, report.cell_size, kLines);
    CAPTURE(scan.first_far);
    CHECK(scan.wrong_far == 0);
    double area = 0;
    for (std::size_t r = 0; r <= model.regions.size(); ++r) {
        for (std::size_t s = r + 1; s <= model.regions.size(); ++s) area += facet_area(meshed.mesh, r, s);
    }
    const double noise = 6 * scan.sample_volume * std::sqrt(static_cast<double>(scan.wrong) + 1);
    CHECK(scan.wrong_volume <= kSurfaceShare * area * report.cell_size + noise);
    for (std::size_t r = 0; r < model.regions.size(); ++r) {
        const double volume = r < meshed.check.region_volume.size() ? meshed.check.region_volume[r] : 0;
        // Samples of a column share their jitter: beside upright faces a scan may be off by more than its
        // spread (random model 141). A finer one has a smaller spread, told by its columns.
        if (!is_volume(scan, area, r, volume)) {
            const ScanResult finer =
                scan_membership(model, meshed.mesh, report.root, report.cell_size, 4 * kLines);
            CAPTURE(finer.model_volume[r]);
            CHECK(std::fabs(volume - finer.model_volume[r]) <=
                  finer.wrong_volume + 6 * finer.volume_spread[r]);
        }
        CHECK(enclosed_volume(meshed.mesh, r + 1) ==
              doctest::Approx(volume).epsilon(1e-7).scale(report.cell_size));
    }
}

}  // namespace mortise::test
