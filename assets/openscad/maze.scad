r=rands(0,1,200,3); cube([42,42,1]); for(i=[0:9],j=[0:9]) if(r[10*i+j]>0.5) translate([i*4,j*4,0]) cube([6,1,6]); else translate([i*4,j*4,0]) cube([1,6,6]);
