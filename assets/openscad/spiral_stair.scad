for(i=[0:15]) rotate(22.5*i) translate([0,0,i*2]) linear_extrude(2.2) polygon([[3,0],[15,0],[14,6],[2.7,1.2]]);
cylinder(r=3.2,h=36,$fn=60);
