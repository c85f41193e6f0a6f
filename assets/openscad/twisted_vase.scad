linear_extrude(height=60,twist=90,scale=0.6,slices=60) for(i=[0:5]) rotate(60*i) translate([8,0]) circle(r=6,$fn=48);
