// Writes the templates of transition cells: generate_transitions FILE (host/cnio/transition_table.hpp).
#include <cstdio>
#include <fstream>

#include "host/templates/transition.hpp"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: generate_transitions FILE\n");
        return 2;
    }
    const auto classes = mortise::templates::build_transitions();
    std::size_t proved = 0;
    for (const auto& row : classes) proved += row.is_fewest ? 1 : 0;
    std::ofstream file(argv[1], std::ios::binary);
    file << mortise::templates::transition_text(classes);
    file.close();
    if (!file) {
        std::fprintf(stderr, "generate_transitions: '%s' cannot be written\n", argv[1]);
        return 1;
    }
    std::printf("%zu classes, %zu of them proved to have the fewest elements\n", classes.size(), proved);
    return 0;
}
