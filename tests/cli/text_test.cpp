// Words of a run's summary.
#include <doctest/doctest.h>

#include "host/cli/text.hpp"

namespace mortise::cli {

TEST_CASE("the summary's times, and what to do where improvement takes most of them") {
    const auto stages = [](double improve, double write) {
        return std::vector<StageTime>{
            {"octree", 0.0004, 0, 1}, {"improve", improve, 0, 1}, {"write", write, 0, 1}};
    };
    CHECK(times_text(stages(1.5, 0.25)) == "  time       1.750 s: improve 1.500, write 0.250\n");
    CHECK(times_text(stages(30, 1)).find("smaller cells may take less time") != std::string::npos);
    CHECK(times_text(stages(30, 40)).find("smaller cells") == std::string::npos);
    CHECK(times_text(stages(5, 1)).find("smaller cells") == std::string::npos);
    CHECK(times_text({}) == "  time       0.000 s\n");
}

}  // namespace mortise::cli
