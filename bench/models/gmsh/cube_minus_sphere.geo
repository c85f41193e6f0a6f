// The solid of ../cube_minus_sphere.geo.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Sphere(2) = {1, 1, 1, 0.55};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
