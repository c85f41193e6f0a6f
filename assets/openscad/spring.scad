// spring as chain of hulls
$fn=16;
for(i=[0:59]) hull(){ translate([10*cos(i*18),10*sin(i*18),i*0.4]) sphere(1.2); translate([10*cos((i+1)*18),10*sin((i+1)*18),(i+1)*0.4]) sphere(1.2);}
