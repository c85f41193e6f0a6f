// The solid of ../cylinders.geo.
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, -2, 0, 0, 4, 1};
Cylinder(2) = {-2, 0, 0, 4, 0, 0, 0.8};
BooleanIntersection(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
