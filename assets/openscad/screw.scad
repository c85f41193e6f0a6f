// screw thread: twisted off-centre circle
$fn=48;
union(){ linear_extrude(height=20,twist=-360*10,slices=200) translate([0.6,0]) circle(r=4);
 cylinder(r=8,h=4,$fn=6); }
