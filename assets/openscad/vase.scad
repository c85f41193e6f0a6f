// A revolved polygon of computed points.
outer=[for(z=[0:4/3:80]) [25+8*sin(z*3.58),z]];
inner=[for(z=[80:-1.2:3]) [22+8*sin(z*3.58),z]];
rotate_extrude() polygon(concat([[0,0]],outer,inner,[[0,3]]));
