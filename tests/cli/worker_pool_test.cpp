// Work in child processes: what one of them loses is told, and the others go on.
#include <csignal>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include "host/cli/worker_pool.hpp"
#include "mortise/error.hpp"

namespace mortise::cli {

TEST_CASE("a worker that throws, ends or is killed costs its own item only") {
    for (const std::size_t jobs : {1, 2, 5}) {
        std::map<std::size_t, std::pair<std::string, int>> results;
        run_in_processes(
            12, jobs,
            [](std::size_t i) -> std::string {
                if (i == 2) throw std::runtime_error("no word of this reaches anyone");
                if (i == 5) std::raise(SIGKILL);
                if (i == 7) std::_Exit(9);
                return "item " + std::to_string(i);
            },
            [&](std::size_t i, const std::string& result, int how) {
                CHECK(results.count(i) == 0);
                results[i] = {result, how};
            });
        REQUIRE(results.size() == 12);
        for (const auto& [i, outcome] : results) {
            const int how = i == 2   ? -static_cast<int>(ExitCode::kDevice)
                            : i == 5 ? SIGKILL
                            : i == 7 ? -9
                                     : 0;
            CHECK(outcome.second == how);
            CHECK(outcome.first == (how == 0 ? "item " + std::to_string(i) : ""));
        }
    }
}

}  // namespace mortise::cli
