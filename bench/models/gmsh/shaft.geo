// The solid of ../shaft.geo.
SetFactory("OpenCASCADE");
Cylinder(1) = {-2, 0, 0, 2.3, 0, 0, 0.6};
Cylinder(2) = {0, 0, 0, 0.6, 0, 0, 1};
Cylinder(3) = {0.3, 0, 0, 1.7, 0, 0, 0.45};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Box(5) = {-1.6, -0.2, 0.3, 1, 0.4, 0.7};
Cylinder(6) = {1.3, 0, -1, 0, 0, 2, 0.2};
BooleanDifference(7) = { Volume{4}; Delete; }{ Volume{5, 6}; Delete; };
