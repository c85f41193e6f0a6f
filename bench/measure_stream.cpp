// From a model to a mesh that is handed on part by part, to a sink that keeps checksums only.
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>

#include "bench/models.hpp"
#include "bench/process.hpp"
#include "bench/workers.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {
namespace {

/// FNV-1a over the values of one array, each a step, however it is cut.
class Checksum {
  public:
    template <class T>
    void add(const std::vector<T>& values) {
        for (const T& value : values) {
            std::uint64_t bits = 0;
            std::memcpy(&bits, &value, sizeof value);
            value_ = (value_ ^ bits) * 0x100000001b3u;
            value_ ^= value_ >> 32;  // high bits of a number must reach low ones
        }
    }
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 0xcbf29ce484222325u;
};

class ChecksumSink : public MeshSink {
  public:
    void begin(const MeshTotals& totals, const Mesh& outline) override {
        wanted = totals;
        sums_[0].add(outline.facets.nodes);
        sums_[0].add(outline.facets.surface);
    }
    void add(const Mesh& part, const std::vector<float>&) override {
        ++parts;
        sums_[1].add(part.points);
        sums_[2].add(part.model_dimension);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            sums_[3 + 2 * t].add(part.elements[t].nodes);
            sums_[4 + 2 * t].add(part.elements[t].region);
        }
    }
    std::string text() const {
        Checksum all;
        for (const Checksum& sum : sums_) all.add(std::vector<std::uint64_t>{sum.value()});
        char text[20];
        std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(all.value()));
        return text;
    }

    MeshTotals wanted;
    std::uint64_t parts = 0;

  private:
    std::array<Checksum, 3 + 2 * kElementTypes> sums_;
};

}  // namespace

nlohmann::json measure_stream(const Task& task) {
    const Model model = make_model(task.model);
    MeshOptions options;
    options.threads = task.threads;
    options.level = task.level;
    options.memory = task.bytes;
    nlohmann::json result = {{"runs", nlohmann::json::array()}};
    for (int run = 0; run < task.repeats; ++run) {
        ChecksumSink sink;
        const auto begin = std::chrono::steady_clock::now();
        Mesher().stream(model, options, sink);
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        result["runs"].push_back({{"seconds", wall.count()}});
        std::uint64_t elements = 0;
        for (const std::uint64_t count : sink.wanted.elements) elements += count;
        result["elements"] = elements;
        result["nodes"] = sink.wanted.nodes;
        result["parts"] = sink.parts;
        result["checksum"] = sink.text();
        result["peak_bytes"] = peak_resident_bytes();
    }
    return result;
}

}  // namespace mortise::bench
