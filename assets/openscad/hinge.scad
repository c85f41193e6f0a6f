$fn=48; 
module leaf(k){ difference(){ union(){ translate([0,-1.5,0]) cube([25,3,30]); for(i=[k:2:4]) translate([0,0,i*6]) cylinder(r=4,h=5.6);} for(i=[1-k:2:4]) translate([0,0,i*6-0.2]) cylinder(r=4.4,h=6); translate([0,0,-1]) cylinder(r=1.6,h=40); for(z=[7,23],x=[12,20]) translate([x,0,z]) rotate([90,0,0]) cylinder(r1=1,r2=2.4,h=4,center=true);} }
leaf(0); rotate(180) leaf(1);
