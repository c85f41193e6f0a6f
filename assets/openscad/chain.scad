$fn=40; module link(){ rotate_extrude(angle=180) translate([6,0]) circle(1.5); translate([6,0,0]) rotate([90,0,0]) cylinder(r=1.5,h=10); translate([-6,0,0]) rotate([90,0,0]) cylinder(r=1.5,h=10); translate([0,-10,0]) rotate(180) rotate_extrude(angle=180) translate([6,0]) circle(1.5);}
link(); translate([0,17,0]) rotate([0,90,0]) link();
