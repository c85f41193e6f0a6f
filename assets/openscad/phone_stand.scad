$fn=32;
linear_extrude(60) offset(r=2) offset(delta=-2) difference(){ union(){ square([70,6]); translate([10,0]) rotate(70) square([90,6]); translate([0,0]) square([6,16]); } translate([30,-1]) square([15,4]); }
