difference(){ intersection(){ cylinder(d=20,h=8,$fn=6); translate([0,0,4]) sphere(r=10.6,$fn=80);} translate([0,0,-1]) linear_extrude(10,twist=-360*5,slices=100) translate([0.4,0]) circle(5,$fn=40);}
