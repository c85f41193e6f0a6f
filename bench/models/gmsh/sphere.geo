// Unit ball; the same solid as ../sphere.geo.
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
