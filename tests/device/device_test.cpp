// The device layer on the machine's default device: choice, memory, launches, builds, times.
#include "host/device/device.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <numeric>
#include <thread>

#include "mortise/error.hpp"
#include "scratch.hpp"

using namespace mortise;
using namespace mortise::device;

namespace {

const char* const kExample =
    "MORTISE_KERNEL void scale(global double* values, double factor, uint items) {\n"
    "    const uint item = get_global_id(0);\n"
    "    if (item >= items) return;\n"
    "    values[item] *= factor;\n"
    "}\n"
    "typedef struct { int a; float b; ulong c; } Plain;\n"
    "MORTISE_KERNEL void gather(global double* out, Plain plain, uint u, ulong w, float f, local int* "
    "scratch,\n"
    "                           uint items) {\n"
    "    const uint item = get_global_id(0);\n"
    "    scratch[get_local_id(0)] = get_local_size(0);\n"
    "    barrier(CLK_LOCAL_MEM_FENCE);\n"
    "    if (item >= items) return;\n"
    "    out[item] = plain.a + plain.b + plain.c + u + w + f + scratch[0] + OFFSET;\n"
    "}\n";

struct Plain {
    std::int32_t a;
    float b;
    std::uint64_t c;
};

/// A device whose kernels/example.cl is kExample.
struct Example {
    ScratchFolder folder;
    DeviceOptions options;
    Example() {
        folder.write("example.cl", kExample);
        options.kernels_folder = folder.path();
    }
};

/// Of this process.
std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t pages = 0, resident = 0;
    file >> pages >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

DeviceInfo fake(const std::string& name, const std::string& platform, bool is_gpu, bool has_double) {
    DeviceInfo info;
    info.name = name;
    info.platform = platform;
    info.is_gpu = is_gpu;
    info.has_double = has_double;
    return info;
}

}  // namespace

TEST_CASE("devices are listed with sound figures") {
    const std::vector<DeviceInfo> devices = list_devices();
    REQUIRE_FALSE(devices.empty());
    for (const DeviceInfo& device : devices) {
        CHECK_FALSE(device.name.empty());
        CHECK_FALSE(device.platform.empty());
        CHECK_FALSE(device.driver.empty());
        CHECK(contains(device.version, "OpenCL"));
        CHECK(device.compute_units > 0);
        CHECK(device.max_work_group > 0);
        CHECK(device.max_allocation_bytes <= device.global_bytes);
    }
}

TEST_CASE("choice of a device") {
    const std::vector<DeviceInfo> devices = {fake("Little GPU", "Vendor", true, false),
                                             fake("Xeon", "Vendor", false, true),
                                             fake("pthread-EPYC", "Portable Computing Language", false, true),
                                             fake("Big GPU", "Vendor", true, true)};
    CHECK(choose_device("0", devices) == 0);
    CHECK(choose_device("3", devices) == 3);
    CHECK(choose_device("gpu", devices) == 0);
    CHECK(choose_device("CPU", devices) == 1);
    CHECK(choose_device("epyc", devices) == 2);
    CHECK(choose_device("portable", devices) == 2);
    {
        const Variable none("MORTISE_DEVICE", "");
        CHECK(choose_device("", devices) == 3);
        CHECK(choose_device("", {devices.begin(), devices.end() - 1}) == 2);
        CHECK(choose_device("", {devices.begin(), devices.begin() + 2}) == 1);
    }
    {
        const Variable chosen("MORTISE_DEVICE", "xeon");
        CHECK(choose_device("", devices) == 1);
        CHECK(choose_device("big", devices) == 3);
    }
    for (const char* wrong : {"4", "99999999999999999999", "radeon"}) {
        const std::string message = device_error([&] { choose_device(wrong, devices); });
        CHECK(contains(message, wrong));
        CHECK(contains(message, "2: pthread-EPYC"));
    }
    const Variable wrong("MORTISE_DEVICE", "nothing");
    CHECK(contains(device_error([&] { Device(""); }), "MORTISE_DEVICE \"nothing\" not found"));
    CHECK(contains(device_error([&] { choose_device("", {}); }), "apt-get install pocl-opencl-icd"));
}

TEST_CASE("options out of range") {
    const auto message = [](int work_group, int lanes) {
        DeviceOptions options;
        options.work_group_size = work_group;
        options.lanes = lanes;
        return device_error([&] { Device("", options); });
    };
    CHECK(contains(message(-1, 0), "work-group size -1"));
    CHECK(contains(message(1 << 30, 0), "limit of"));
    CHECK(contains(message(0, 3), "lanes 3"));
}

TEST_CASE("uploads, downloads, copies, fills and mappings move the right bytes") {
    Device device;
    std::vector<std::uint32_t> values(1000);
    std::iota(values.begin(), values.end(), 1u);
    Buffer buffer = device.upload(values);
    CHECK(buffer.count<std::uint32_t>() == 1000);
    CHECK(device.download<std::uint32_t>(buffer, 1000) == values);
    const std::uint32_t two[] = {7, 8};
    device.upload(buffer, two, 2, 998);
    CHECK(device.download<std::uint32_t>(buffer, 3, 997) == std::vector<std::uint32_t>{998, 7, 8});
    device.fill_zero(buffer, 8, 4);
    CHECK(device.download<std::uint32_t>(buffer, 4) == std::vector<std::uint32_t>{1, 0, 0, 4});
    {
        auto mapped = device.map<std::uint32_t>(buffer, Access::kReadWrite, 3, 3);
        REQUIRE(mapped.size() == 3);
        CHECK(mapped[1] == 5);
        for (std::uint32_t& value : mapped) value += 100;
    }
    Buffer other = device.allocate(16);
    device.copy(buffer, other, 16, 8);
    CHECK(device.download<std::uint32_t>(other, 4) == std::vector<std::uint32_t>{0, 104, 105, 106});
    device.fill_zero(other);
    CHECK(device.download<std::uint32_t>(other, 4) == std::vector<std::uint32_t>(4, 0));

    Buffer moved = std::move(other);
    CHECK(moved.bytes() == 16);
    CHECK(other.bytes() == 0);  // NOLINT: a moved-from buffer is empty, by contract
    CHECK_FALSE(other);

    Buffer empty = device.allocate(0);
    CHECK(empty);
    CHECK(device.download<int>(empty, 0).empty());
    CHECK(device.map<int>(empty, Access::kRead).size() == 0);
    device.fill_zero(empty);

    CHECK(contains(device_error([&] { device.upload(buffer, two, 2, 999); }),
                   "outside a buffer of 4000 bytes"));
    CHECK(contains(device_error([&] { device.download<char>(buffer, 1, 4000); }), "download"));
    CHECK(contains(device_error([&] { device.map<char>(buffer, Access::kRead, 1, ~std::size_t{0}); }),
                   "mapping"));
    CHECK(contains(device_error([&] { device.fill_zero(buffer, 4001); }), "filling"));
    CHECK(contains(device_error([&] { device.copy(buffer, moved, 17); }), "copying to"));
}

TEST_CASE("buffers count as memory while they live, and may outlive the device") {
    Buffer survivor;
    {
        Device device;
        const MemoryUse before = device.memory();
        {
            const Buffer a = device.allocate(1000);
            survivor = device.allocate(24);
            CHECK(device.memory().bytes == before.bytes + 1024);
        }
        CHECK(device.memory().bytes == before.bytes + 24);
        CHECK(device.memory().peak >= before.bytes + 1024);
    }
    CHECK(survivor.bytes() == 24);
}

TEST_CASE("large buffers hold what is put there, and give their memory back") {
    constexpr std::size_t kCount = (std::size_t{40} << 20) / sizeof(std::uint32_t) + 5;
    std::vector<std::uint32_t> values(kCount);
    std::iota(values.begin(), values.end(), 1u);
    Buffer survivor;
    {
        Device device;
        Buffer copy = device.allocate(kCount * sizeof(std::uint32_t));
        device.copy(device.upload(values), copy, copy.bytes());
        CHECK(device.download<std::uint32_t>(copy, kCount) == values);
        const std::size_t before = resident_bytes();
        for (int i = 0; i < 20; ++i) {
            Buffer buffer = device.allocate(kCount * sizeof(std::uint32_t));
            device.fill_zero(buffer);  // may still run when the buffer goes
        }
        device.finish();
        CHECK(resident_bytes() < before + 4 * kCount * sizeof(std::uint32_t));
        survivor = std::move(copy);
    }
    CHECK(survivor.bytes() == kCount * sizeof(std::uint32_t));
}

TEST_CASE("a buffer over the device's largest allocation is refused with figures") {
    Device device;
    const std::string message = device_error([&] { device.allocate(std::size_t{1} << 52); });
    CAPTURE(message);
    CHECK(contains(message, "4503599627370496 bytes"));
    CHECK(contains(message, "largest allocation"));
    CHECK(contains(message, device.info().name));
}

TEST_CASE("launch: arguments of every kind, padding, events and times") {
    Example example;
    for (const int group : {1, 7, 64}) {
        example.options.work_group_size = group;
        Device device("", example.options);
        CHECK(device.work_group_size() == group);
        std::vector<double> values(129);
        std::iota(values.begin(), values.end(), 1.0);
        Buffer buffer = device.upload(values);
        const Kernel scale = device.kernel("example.cl", "scale", "-DOFFSET=0");
        CHECK(scale.entry() == "scale");
        const Event event = device.launch(scale, 100, buffer, 2.0);
        std::thread([&] { event.wait(); }).join();
        CHECK(event.done());
        const std::vector<double> scaled = device.download<double>(buffer, 129);
        for (std::size_t i = 0; i < 129; ++i) CHECK(scaled[i] == values[i] * (i < 100 ? 2 : 1));

        const Kernel gather = device.kernel("example.cl", "gather", "-DOFFSET=1000");
        const Plain plain{1, 0.5f, 16};
        device.launch(gather, 3, buffer, plain, std::uint32_t{2}, std::uint64_t{4}, 0.25f,
                      LocalMemory{static_cast<std::size_t>(group) * 4});
        CHECK(device.map<double>(buffer, Access::kRead)[2] == 1023.75 + group);

        CHECK(device.launch(scale, 0, buffer, 2.0).done());
        std::vector<KernelTime> times = device.times();
        REQUIRE(times.size() == 2);
        if (times[0].entry != "scale") std::swap(times[0], times[1]);
        CHECK(times[0].launches == 1);
        CHECK(times[0].items == 100);
        CHECK(times[0].seconds > 0);
        device.reset_times();
        CHECK(device.times().empty());
        for (int i = 0; i < 1000; ++i) device.launch(scale, 1, buffer, 1.0);
        device.finish();
        REQUIRE(device.times().size() == 1);
        CHECK(device.times()[0].launches == 1000);
    }
}

TEST_CASE("wrapped host memory is what kernels see, and the other way round") {
    for (const bool copies : {false, true}) {
        CAPTURE(copies);
        Example example;
        example.options.copies = copies;
        Device device("", example.options);
        std::vector<double> values(1000, 3.0);
        Buffer buffer = device.wrap(values.data(), values.size() * sizeof(double));
        device.sync_to_device(buffer);
        const Kernel scale = device.kernel("example.cl", "scale", "-DOFFSET=0");
        device.launch(scale, 1000, buffer, 2.0);
        device.sync_to_host(buffer);
        CHECK(values == std::vector<double>(1000, 6.0));
        for (double& value : values) value = 5.0;
        device.sync_to_device(buffer);
        device.launch(scale, 999, buffer, 2.0);
        device.sync_to_host(buffer);
        CHECK(values[998] == 10.0);
        CHECK(values[999] == 5.0);
        const std::vector<double> lent = {1, 2, 3};
        Buffer sums = device.upload(std::vector<double>(3, 0.0));
        device.copy(device.lend(lent.data() + 1, 2), sums, 2 * sizeof(double));
        CHECK(device.download<double>(sums, 3) == std::vector<double>{2, 3, 0});
        CHECK(device.wrap(nullptr, 0).bytes() == 0);
    }
}

TEST_CASE("misuse of a launch is named") {
    Example example;
    Device device("", example.options);
    Buffer buffer = device.allocate(80);
    const Kernel scale = device.kernel("example.cl", "scale", "-DOFFSET=0");
    CHECK(contains(device_error([&] { device.launch(scale, 1, buffer); }), "launched with 2 arguments"));
    CHECK(contains(device_error([&] { device.launch(scale, 1, Buffer(), 1.0); }),
                   "argument 0 is an empty buffer"));
    CHECK(contains(device_error([&] { device.launch(scale, 1, buffer, 1.0f); }), "argument 1 of 4 bytes"));
    CHECK(contains(device_error([&] { device.launch(scale, std::size_t{1} << 32, buffer, 1.0); }),
                   "4294967296"));
    CHECK(contains(device_error([&] { device.launch(Kernel(), 1); }), "empty kernel"));
    const auto mapped = device.map<double>(buffer, Access::kRead);
    CHECK(contains(device_error([&] { device.launch(scale, 1, buffer, 1.0); }), "still mapped"));
}

TEST_CASE("a failing build names file and line") {
    ScratchFolder folder;
    folder.write("bad.cl", "#include \"shared/bad.h\"\nMORTISE_KERNEL void fine(uint items) {}\n");
    folder.write("shared/bad.h", "\n\nint twice(int x) { return 2 * y; }\n");
    folder.write("warns.cl",
                 "MORTISE_KERNEL void warns(global int* p, uint items) { p[0] = 1 == 1.5f ? p : 0; }\n");
    DeviceOptions options;
    options.kernels_folder = folder.path();
    Device device("", options);
    const std::string message = device_error([&] { device.kernel("bad.cl", "fine"); });
    CAPTURE(message);
    CHECK(contains(message, "kernels/bad.cl does not build"));
    CHECK(contains(message, "kernels/shared/bad.h:3"));
    CHECK(contains(message, "'y'"));
    const bool is_pocl = device.info().platform == "Portable Computing Language";
    if (is_pocl) {  // other compilers' warnings are not errors
        CHECK(contains(device_error([&] { device.kernel("warns.cl", "warns"); }), "kernels/warns.cl:1"));
    }
    CHECK(contains(device_error([&] { device.kernel("none.cl", "fine"); }), "kernels/none.cl"));
    CHECK(
        contains(device_error([&] { device.kernel("scan.cl", "nothing", "-DSUM=uint"); }), "kernel nothing"));
    CHECK(contains(device_error([&] { device.kernel("scan.cl", "scan_sums", "-no-such-option"); }),
                   "-no-such-option"));
}

TEST_CASE("a kernel that needs too much local memory is refused before it is launched") {
    ScratchFolder folder;
    folder.write("greedy.cl",
                 "MORTISE_KERNEL void greedy(global int* out, uint items) {\n"
                 "    local int memory[1 << 26];\n"
                 "    memory[get_local_id(0)] = items;\n"
                 "    barrier(CLK_LOCAL_MEM_FENCE);\n"
                 "    out[get_global_id(0)] = memory[0];\n"
                 "}\n");
    DeviceOptions options;
    options.kernels_folder = folder.path();
    Device device("", options);
    const std::string message = device_error([&] { device.kernel("greedy.cl", "greedy"); });
    CAPTURE(message);
    CHECK(contains(message, "local memory"));
}

TEST_CASE("programs come from the cache folder, and a damaged one does not matter") {
    ScratchFolder cache;
    const Variable folder("MORTISE_CACHE", cache.path());
    Example example;
    const auto entries = [&] {
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(cache.path()))
            files.push_back(entry.path());
        return files;
    };
    const auto run = [&] {
        Device device("", example.options);
        Buffer buffer = device.upload(std::vector<double>{1.5});
        device.launch(device.kernel("example.cl", "scale", "-DOFFSET=0"), 1, buffer, 2.0);
        CHECK(device.download<double>(buffer, 1)[0] == 3.0);
    };
    const mode_t before = umask(022);
    const std::string unfinished = cache.path() + "/1-0.new";  // of a run that was killed yesterday
    std::ofstream(unfinished) << "half of a program";
    std::filesystem::last_write_time(unfinished,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(24));
    run();
    umask(before);
    CHECK(entries().size() == 3);  // the probe's program and result, and this one
    using std::filesystem::perms;
    for (const auto& file : entries()) {
        const perms readable =
            perms::owner_read | perms::owner_write | perms::group_read | perms::others_read;
        CHECK(std::filesystem::status(file).permissions() == readable);
    }
    std::vector<std::pair<std::filesystem::path, std::filesystem::file_time_type>> stamps;
    for (const auto& file : entries()) stamps.emplace_back(file, std::filesystem::last_write_time(file));
    run();
    for (const auto& [file, stamp] : stamps) CHECK(std::filesystem::last_write_time(file) == stamp);

    for (const auto& file : entries()) std::ofstream(file, std::ios::binary) << "not a program";
    run();
    for (const auto& file : entries()) CHECK(std::filesystem::file_size(file) > 100);

    example.folder.write("example.cl", std::string(kExample) + "// changed\n");
    run();
    CHECK(entries().size() == 4);
    example.options.disk_cache = false;
    example.folder.write("example.cl", std::string(kExample) + "// changed again\n");
    run();
    CHECK(entries().size() == 4);
}

TEST_CASE("programs that are loaded ahead are those of the cache folder; others are built when asked for") {
    ScratchFolder cache;
    const Variable folder("MORTISE_CACHE", cache.path());
    Example example;
    const std::string defines = "-DOFFSET=0";
    const std::vector<ProgramName> programs = {{"none.cl", ""}, {"example.cl", defines}};
    const auto run = [&](bool ahead) {
        Device device("", example.options);
        if (ahead) device.load_ahead(programs);
        Buffer buffer = device.upload(std::vector<double>{1.5});
        device.launch(device.kernel("example.cl", "scale", defines), 1, buffer, 2.0);
        CHECK(device.download<double>(buffer, 1)[0] == 3.0);
        if (ahead) device.load_ahead(programs);  // once more: nothing left to do
        CHECK(contains(device_error([&] { device.kernel("none.cl", "none"); }), "none.cl"));
    };
    SUBCASE("not there yet") { run(true); }
    SUBCASE("there") {
        run(false);
        run(true);
    }
    SUBCASE("there, but damaged") {
        run(false);
        for (const auto& entry : std::filesystem::directory_iterator(cache.path()))
            std::ofstream(entry.path(), std::ios::binary) << "not a program";
        run(true);
    }
    SUBCASE("a device that goes away meanwhile") {
        run(false);
        for (int again = 0; again < 20; ++again) Device("", example.options).load_ahead(programs);
    }
}

TEST_CASE("MORTISE_KERNELS replaces the embedded kernels") {
    Example example;
    const Variable folder("MORTISE_KERNELS", example.folder.path());
    Device device;
    CHECK(device.kernel("example.cl", "scale", "-DOFFSET=0").entry() == "scale");
}
