for(i=[0:9],j=[0:9]) translate([i*4,j*4,0]) cube([4,4,1+rands(0,6,100,7)[10*i+j]]);
