$fn=80;
difference(){ union(){ cylinder(r=10,h=40); rotate([90,0,0]) translate([0,20,0]) cylinder(r=7,h=25); cylinder(r=16,h=4); translate([0,-25,20]) rotate([90,0,0]) cylinder(r=12,h=3,center=true);} translate([0,0,-1]) cylinder(r=8,h=50); rotate([90,0,0]) translate([0,20,0]) cylinder(r=5,h=40); for(i=[0:5]) rotate(60*i) translate([13,0,-1]) cylinder(r=1.5,h=8);}
