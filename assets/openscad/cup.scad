$fn=80; difference(){ union(){ cylinder(r1=15,r2=20,h=40); translate([24,0,20]) rotate([90,0,0]) rotate_extrude() translate([10,0]) circle(3);} translate([0,0,3]) cylinder(r1=12.5,r2=18,h=38); }
