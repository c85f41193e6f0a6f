$fn=60;
module tube(r,h){ difference(){ cylinder(r=r,h=h); translate([0,0,-1]) cylinder(r=r-2,h=h+2);} }
translate([20,0,0]) rotate([90,0,0]) tube(6,30);
rotate_extrude(angle=90) translate([20,0]) difference(){ circle(6); circle(4); }
translate([0,20,0]) rotate([0,-90,0]) tube(6,20);
