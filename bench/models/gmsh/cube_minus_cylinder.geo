// The solid of ../cube_minus_cylinder.geo.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Cylinder(2) = {0.6, 0.4, -0.5, 0, 0, 2, 0.22};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
