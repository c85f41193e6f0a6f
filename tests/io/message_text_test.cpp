// Numbers, counts and names in messages.
#include <doctest/doctest.h>

#include <cstdio>

#include "host/common/box_faces.hpp"
#include "host/common/message_text.hpp"

using namespace mortise;

TEST_CASE("rounded numbers are those of printf in the C locale") {
    for (const double value :
         {0.0, -0.0, 1.0, 0.1, 2.0 / 3, 1e-300, 1e300, 123456.5, 1234567.0, -0.00012345}) {
        for (const int digits : {2, 4, 6, 9, 17}) {
            char expected[64];
            std::snprintf(expected, sizeof expected, "%.*g", digits, value);
            CHECK(rounded_text(value, digits) == expected);
        }
    }
    CHECK(rounded_text(1.0 / 3, 100) == rounded_text(1.0 / 3, 17));
    CHECK(place_text({1, 2.5, -1e-7}) == "(1, 2.5, -1e-07)");
}

TEST_CASE("counts have the word that goes with them") {
    CHECK(counted(1, "edge") == "1 edge");
    CHECK(counted(0, "edge") == "0 edges");
    CHECK(counted(2, "line is", "lines are") == "2 lines are");
}

TEST_CASE("faces of the box are known by their whole name") {
    CHECK(is_box_face("box_zmax"));
    CHECK_FALSE(is_box_face("box_lid"));
    CHECK_FALSE(is_box_face("box_"));
}
