$fn=50;
module pip(x,y){ translate([x,y,10]) sphere(1.8); }
difference(){ intersection(){ cube(20,center=true); sphere(14); }
 pip(0,0); rotate([90,0,0]){ pip(5,5); pip(-5,-5); } rotate([-90,0,0]){ pip(5,5); pip(-5,-5); pip(0,0); }
 rotate([0,90,0]){ pip(5,5); pip(-5,-5); pip(5,-5); pip(-5,5); }
 rotate([0,-90,0]){ pip(5,5); pip(-5,-5); pip(5,-5); pip(-5,5); pip(0,0); }
 rotate([180,0,0]) for(y=[-5,0,5]){ pip(5,y); pip(-5,y); } }
